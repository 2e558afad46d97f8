#include "sightline/engine/paged/internal/placeholders.h"

#include <algorithm>
#include <cmath>

namespace sightline::engine {
namespace {

constexpr int kLevels = 16;  // of each channel in the palette
constexpr std::uint32_t kPart = 1 << 15;

std::uint32_t palette_row(std::uint32_t colour) {
  const auto level = [&](int shift) { return (colour >> shift & 255u) * (kLevels - 1) / 255u; };
  return 1 + (level(16) * kLevels + level(8)) * kLevels + level(0);
}

}  // namespace

core::Expected<Placeholders> Placeholders::create(const gl::Context& context, const render::TargetFormat& format) {
  auto points = render::PointSplats::create(context, format);
  if (!points) return tl::unexpected(points.error());
  auto palette = std::make_unique<Palette>();
  const float step = 1.0f / (kLevels - 1);
  for (int b = 0; b < kLevels; ++b)
    for (int g = 0; g < kLevels; ++g)
      for (int r = 0; r < kLevels; ++r)
        palette->scene.add_material({{}, {float(r) * step, float(g) * step, float(b) * step}});
  palette->snapshot = core::Snapshot(palette->scene);
  auto colours = gpuscene::GpuScene::create(context, palette->snapshot);
  if (!colours) return tl::unexpected(colours.error());
  return Placeholders(std::move(*points), std::move(palette), std::move(*colours));
}

/// Part by part, so that millions of leaves take no more memory than the image has pixels.
void Placeholders::find(const core::PagedScene& scene, const core::View& view, const core::VisibleSet& leaves,
                        const render::RenderTarget& target) {
  const int width = target.width(), height = target.height();
  const culling::ContributionTest test(view, scene.leaves.origin, width, height);
  forget(width, height);
  parts_.split(leaves, kPart);
  for (std::uint32_t i = 0; i < parts_.count(); ++i) {
    test.splats(scene.leaves, parts_[i], {}, 0.0f, culling::ContributionTest::SplatRule::kOnPixelCentres, found_);
    for (const auto& square : found_) {
      const int x = std::clamp(int(std::lround(square.x)), 0, width - 1);
      const int y = std::clamp(int(std::lround(square.y)), 0, height - 1);
      Nearest& at = nearest_[std::size_t(y) * std::size_t(width) + std::size_t(x)];
      if (square.distance < at.distance) at = {square.distance, square.slot, square.area};
    }
  }
}

core::Expected<void> Placeholders::draw(const core::PagedScene& scene, const core::View& view,
                                        const core::VisibleSet& leaves, const render::RenderTarget& target) {
  find(scene, view, leaves, target);
  splats_.clear();
  for (const Nearest& at : nearest_) {
    if (at.leaf == core::kNone) continue;
    const core::Aabb box = scene.leaves.box(at.leaf);
    const core::dvec3 centre = 0.5 * (core::dvec3(box.min) + core::dvec3(box.max)) + scene.leaves.origin;
    const core::vec3 eye(view.eye_from_world() * core::dvec4(centre, 1.0));
    splats_.push_back({eye, std::min(std::sqrt(at.area), points_.largest_side()), core::kNoItem,
                       palette_row(scene.colours[at.leaf])});
  }
  return points_.draw(view, splats_, colours_, target);
}

}  // namespace sightline::engine
