#include "sightline/engine/drawing/internal/left_out.h"

#include <algorithm>

namespace sightline::engine {
namespace {

/// Slots of `all` that are not in `kept`.
std::vector<std::uint64_t> without(const core::VisibleSet& all, const core::VisibleSet& kept, std::size_t slots) {
  std::vector<std::uint64_t> bits(culling::bit_words(slots)), kept_bits(bits);
  culling::set_bits(all, bits);
  culling::set_bits(kept, kept_bits);
  for (std::size_t i = 0; i < bits.size(); ++i) bits[i] &= ~kept_bits[i];
  return bits;
}

}  // namespace

core::Expected<LeftOut> find_left_out(DrawContext& context, ImageOverlays& overlays, const Frame& frame,
                                      const core::VisibleSet& visible) {
  const core::ItemBounds& bounds = frame.snapshot.bounds();
  const float least = context.config.losses.min_projected_area;
  LeftOut out;
  core::VisibleSet large, sampled, shown;
  const core::VisibleSet* left = &visible;
  if (least > 0.0f) {
    context.contribution_test(frame).filter(bounds, *left, least, large, {}, frame.lines);
    left = &large;
  }
  if (context.config.culling.sample_test || context.may_test_occlusion()) {
    context.sample_test(frame).filter(bounds, *left, sampled, frame.lines, &context.threads);
    left = &sampled;
  }
  if (left != &visible) out.small = without(visible, *left, bounds.size());
  if (!context.may_test_occlusion()) return out;
  const core::VisibleSet& opaque = overlays.split(context, *left);
  if (auto done = DrawInPasses().draw(context, frame, opaque); !done) return tl::unexpected(done.error());
  context.occlusion_test(frame).filter(bounds, *left, shown, frame.lines, &context.threads);
  out.occluded = without(*left, shown, bounds.size());
  return out;
}

namespace {

/// Visible items that the last frame has not drawn, in rising order.
core::VisibleSet missing_items(const DrawContext& context, const core::ItemBounds& bounds,
                               const core::VisibleSet& visible) {
  const ImageState& image = *context.image;
  std::vector<std::uint64_t> drawn = image.was_large;
  if (context.config.losses.budget_ms > 0.0 && !image.whole) image.budget.looked_at(bounds.size(), drawn);
  core::VisibleSet missing;
  visible.for_each_slot([&](core::Slot slot) {
    if (!bounds.vacant(slot) && !culling::contains(drawn, slot)) missing.single_slots.push_back(slot);
  });
  std::sort(missing.single_slots.begin(), missing.single_slots.end());
  return missing;
}

/// What levels of detail cost the image as it is now.
LossReport loss_by_levels(const ImageState& image) {
  MeshCounts meshes = image.meshes;
  meshes += image.meshes_over;
  const double coarseness = image.shows_moving() ? image.budget_counts.coarseness : 1.0;
  return {.lod_error = meshes.error * coarseness,
          .triangles = meshes.triangles,
          .full_triangles = meshes.full_triangles,
          .coarseness = coarseness,
          .coarser_share = double(meshes.coarser) / double(std::max<std::int64_t>(meshes.items, 1))};
}

}  // namespace

/// Tests against the image as it is now, with a depth pyramid beside the image's: what a budget goes on with must stay.
core::Expected<LossReport> measure_loss(DrawContext& context, const Frame& frame, const core::VisibleSet& visible) {
  LossReport report = loss_by_levels(*context.image);
  const ImageState& image = *context.image;
  const bool in_time = context.config.losses.budget_ms <= 0.0 || image.whole;
  if (image.shows_moving() || (in_time && context.config.losses.min_projected_area <= 0.0f)) return report;
  const core::ItemBounds& bounds = frame.snapshot.bounds();
  const render::RenderTarget& target = context.target();
  core::VisibleSet sampled, unoccluded;
  context.sample_test(frame).filter(bounds, missing_items(context, bounds, visible), sampled);
  const core::VisibleSet* left = &sampled;
  if (target.format().samples == 1 && !sampled.single_slots.empty()) {
    std::vector<float> distances;
    culling::DepthPyramid pyramid;
    if (auto read = target.read_distances(frame.view, distances); !read) return tl::unexpected(read.error());
    pyramid.build(distances, target.width(), target.height());
    context.occlusion_test(frame, pyramid).filter(bounds, sampled, unoccluded);
    left = &unoccluded;
  }
  std::vector<culling::ContributionTest::SlotArea> areas;
  context.contribution_test(frame).areas(bounds, *left, areas);
  report.items = std::int64_t(areas.size());
  for (const auto& area : areas) report.pixels += double(area.area);
  report.pixels = std::min(report.pixels, double(target.width()) * target.height());
  return report;
}

}  // namespace sightline::engine
