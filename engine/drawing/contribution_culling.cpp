#include "sightline/engine/drawing/internal/contribution_culling.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "sightline/core/internal/store.h"

namespace sightline::engine {
namespace {

using Splat = culling::ContributionTest::Splat;

float side_of(const Splat& square, float least_area) {
  return std::sqrt(std::max(square.area, least_area));
}

/// For each pixel, how far the nearest surface is that is known to be drawn there. Several threads may use it.
class NearestDrawn {
 public:
  /// `error`: metres by which the distances may be off.
  NearestDrawn(std::span<float> distances, int width, int height, float error)
      : distances_(distances), width_(width), height_(height), error_(error) {}

  /// Whether a square may cover a pixel centre where nothing nearer is known.
  bool shows(const Splat& square, float side) const {
    const float distance = square.distance - error_ - 1e-4f * std::abs(square.distance);
    return any_pixel(square, 0.5f * side + kMargin, [&](float& at) { return known(at).load(kOrder) >= distance; });
  }
  /// A square that will be drawn unless others hide it.
  void add(const Splat& square, float side) const {
    any_pixel(square, 0.5f * side - kMargin, [&](float& at) {
      for (float before = known(at).load(kOrder); square.distance < before;)
        if (known(at).compare_exchange_weak(before, square.distance, kOrder)) break;
      return false;
    });
  }

 private:
  static constexpr float kMargin = 0.01f;  // pixels by which a square may be drawn elsewhere
  static constexpr auto kOrder = std::memory_order_relaxed;
  static std::atomic_ref<float> known(float& at) { return std::atomic_ref<float>(at); }

  /// Whether visit(distance) is true of a pixel whose centre is no farther than `reach` along both axes.
  template <class Visit>
  bool any_pixel(const Splat& square, float reach, const Visit& visit) const {
    // Without std::floor and std::ceil, which are function calls where the instruction set has neither.
    const auto first = [reach](float at) {
      const float least = std::max(0.0f, at - reach);
      return int(least) + int(float(int(least)) < least);
    };
    const auto last = [reach](float at, int size) {
      const float most = at + reach;
      return most < 0.0f ? -1 : std::min(size - 1, int(most));
    };
    const int x0 = first(square.x), x1 = last(square.x, width_), y1 = last(square.y, height_);
    for (int y = first(square.y); y <= y1; ++y)
      for (int x = x0; x <= x1; ++x)
        if (visit(distances_[std::size_t(y) * std::size_t(width_) + std::size_t(x)])) return true;
    return false;
  }

  std::span<float> distances_;
  int width_, height_;
  float error_;
};

/// Points of eye space that are at given places in the image.
class Unprojection {
 public:
  Unprojection(const core::View& view, int width, int height) {
    const core::dmat4& clip = view.clip_from_eye();
    const auto axis = [&](int i, int size) {
      return Axis{float(2.0 / (size * clip[i][i])), float(0.5 * size - 0.5), float(clip[2][i] / clip[i][i]),
                  float(clip[3][i] / clip[i][i])};
    };
    x_ = axis(0, width);
    y_ = axis(1, height);
    w_ = {float(clip[2][3]), float(clip[3][3])};
  }

  core::vec3 eye(const Splat& square) const {
    const float z = -square.distance, w = w_.x * z + w_.y;
    return {x_.at(square.x, z, w), y_.at(square.y, z, w), z};
  }

 private:
  struct Axis {
    float per_pixel, middle, per_z, constant;
    float at(float place, float z, float w) const { return (place - middle) * per_pixel * w - per_z * z - constant; }
  };
  Axis x_, y_;
  glm::vec2 w_;
};

/// Whether the rasteriser keeps a point that far from the eye.
class NearAndFar {
 public:
  explicit NearAndFar(const core::View& view)
      : planes_(core::frustum_planes(view.clip_from_eye(), view.clip_depth())) {}
  bool contain(float distance) const { return inside(core::kNear, distance) && inside(core::kFar, distance); }

 private:
  bool inside(core::FrustumPlane which, float distance) const {
    const core::Plane& plane = planes_[std::size_t(which)];
    return plane.offset - plane.normal.z * double(distance) > 0.0;
  }
  std::array<core::Plane, core::kFrustumPlaneCount> planes_;
};

}  // namespace

bool in_share(core::ItemId item, float share) {
  // The last step of MurmurHash3 (A. Appleby): each bit of the id changes each bit of the result with probability 1/2.
  std::uint32_t h = to_index(item) + 0x9e3779b9u;
  h = (h ^ h >> 16) * 0x85ebca6bu;
  h = (h ^ h >> 13) * 0xc2b2ae35u;
  h ^= h >> 16;
  return float(h >> 8) * 0x1p-24f < share;
}

/// Squares hide each other, too. What is nearest in each pixel does not depend on the order in which threads add them.
void ContributionCulling::find(DrawContext& context, const Frame& frame, const core::VisibleSet& visible,
                               const Splats& wanted) {
  using SplatRule = culling::ContributionTest::SplatRule;
  const core::Snapshot& snapshot = frame.snapshot;
  const float least_area = wanted.least_area;
  const render::RenderTarget& target = context.target();
  const culling::ContributionTest test = context.contribution_test(frame);
  const culling::OcclusionTest occlusion = context.occlusion_test(frame);
  const bool one_sample = target.format().samples == 1;
  const float largest_side = points_->largest_side();
  nearest_.clear();
  if (wanted.depth_known) nearest_ = context.image->distances;
  nearest_.resize(std::size_t(target.width()) * std::size_t(target.height()), std::numeric_limits<float>::infinity());
  const NearestDrawn nearest(nearest_, target.width(), target.height(),
                             float(render::RenderTarget::orthographic_error(frame.view)));
  const NearAndFar range(frame.view);
  const Unprojection unprojection(frame.view, target.width(), target.height());
  const auto side = [&](const Splat& square) { return side_of(square, least_area); };
  const auto hidden = [&](const Splat& square) { return !nearest.shows(square, side(square)); };
  const auto hides = [&](const Splat& square) {
    return frame.view.sections.empty() && snapshot.opaque(square.slot) && range.contain(square.distance);
  };
  parts_.split(visible);
  if (of_part_.size() < parts_.count()) of_part_.resize(parts_.count());
  parts_.for_each(&context.threads, [&](core::VisibleSet& part, std::uint32_t i) {
    core::VisibleSet& open = of_part_[i].open;
    std::vector<Splat>& candidates = of_part_[i].candidates;
    if (wanted.depth_known && frame.hierarchy) {
      occlusion.filter_leaves(*frame.hierarchy, part, open);
      std::swap(part, open);
    }
    test.splats(snapshot.bounds(), part, wanted.large, least_area,
                one_sample ? SplatRule::kOnPixelCentres : SplatRule::kAll, candidates);
    if (least_area > 0.0f)
      std::erase_if(candidates, [&](const Splat& square) {
        return !in_share(snapshot.item(square.slot), square.area / least_area);
      });
    if (!one_sample) return;
    std::erase_if(candidates, hidden);
    for (const Splat& square : candidates)
      if (hides(square)) nearest.add(square, side(square));
  });
  parts_.for_each(&context.threads, [&](core::VisibleSet&, std::uint32_t i) {
    std::vector<render::PointSplat>& splats = of_part_[i].splats;
    splats.clear();
    for (const Splat& square : of_part_[i].candidates)
      if (!one_sample || !hidden(square))
        splats.push_back({unprojection.eye(square), std::min(side(square), largest_side), snapshot.item(square.slot),
                          gpuprims::material_row(snapshot, square.slot)});
  });
  splats_.clear();
  for (std::uint32_t i = 0; i < parts_.count(); ++i)
    splats_.insert(splats_.end(), of_part_[i].splats.begin(), of_part_[i].splats.end());
}

const core::VisibleSet& ContributionCulling::leave_out(DrawContext& context, const Frame& frame,
                                                       const core::VisibleSet& candidates, float threshold) {
  if (threshold <= 0.0f) return candidates;
  const core::ItemBounds& bounds = frame.snapshot.bounds();
  const culling::ContributionTest test = context.contribution_test(frame);
  if (frame.hierarchy) test.filter_leaves(*frame.hierarchy, candidates, threshold, large_leaves_, frame.lines);
  std::vector<std::uint64_t>& was_large = context.image->was_large;
  culling::filter_in_parts(frame.hierarchy ? large_leaves_ : candidates, large_, &context.threads,
                           [&](const core::VisibleSet& in, core::VisibleSet& out) {
                             test.filter(bounds, in, threshold, out, was_large, frame.lines);
                           });
  was_large.assign(culling::bit_words(bounds.size()), 0);
  culling::set_bits(large_, was_large);
  return large_;
}

core::Expected<std::int64_t> ContributionCulling::draw(DrawContext& context, const Frame& frame,
                                                       const core::VisibleSet& visible, const Splats& splats) {
  if (!points_) {
    if (auto done = core::store(render::PointSplats::create(context.context, context.target().format()), points_);
        !done)
      return tl::unexpected(done.error());
  }
  find(context, frame, visible, splats);
  auto done = points_->draw(frame.view, splats_, *context.scene, context.target());
  return done.map([&] { return std::int64_t(splats_.size()); });
}

}  // namespace sightline::engine
