#include "sightline/engine/internal/small_items.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sightline::engine {
namespace {

using Square = culling::ContributionTest::Square;

float side_of(const Square& square, float fixed_side) {
  return fixed_side > 0.0f ? fixed_side : std::sqrt(square.area);
}

/// Of each pixel, how far the nearest surface is that is known to be drawn there.
class NearestDrawn {
 public:
  /// `error`: metres by which the distances may be off.
  NearestDrawn(std::span<float> distances, int width, int height, float error)
      : distances_(distances), width_(width), height_(height), error_(error) {}

  /// Whether a square may cover a pixel centre where nothing nearer is known.
  bool shows(const Square& square, float side) const {
    const float distance = square.distance - error_ - 1e-4f * std::abs(square.distance);
    return any_pixel(square, 0.5f * side + kMargin, [&](const float& known) { return known >= distance; });
  }
  /// A square that will be drawn.
  void add(const Square& square, float side) {
    any_pixel(square, 0.5f * side - kMargin, [&](float& known) {
      known = std::min(known, square.distance);
      return false;
    });
  }

 private:
  static constexpr float kMargin = 0.01f;  // pixels by which a square may be drawn elsewhere

  /// Whether visit(distance) is true of a pixel whose centre is no farther than `reach` along both axes.
  template <class Visit>
  bool any_pixel(const Square& square, float reach, const Visit& visit) const {
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

/// Points of eye space that are at given places in the picture.
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

  core::vec3 eye(const Square& square) const {
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
  std::uint32_t h = item + 0x9e3779b9u;
  h = (h ^ h >> 16) * 0x85ebca6bu;
  h = (h ^ h >> 13) * 0xc2b2ae35u;
  h ^= h >> 16;
  return float(h >> 8) * 0x1p-24f < share;
}

/// Squares hide each other, too. Those of a second look see all that are nearer.
void SmallItems::leave_out_hidden(const core::View& view, const core::Snapshot& snapshot, float fixed_side,
                                  std::span<const float> distances, const render::RenderTarget& target) {
  const std::size_t pixels = std::size_t(target.width()) * std::size_t(target.height());
  if (distances.empty())
    nearest_.assign(pixels, std::numeric_limits<float>::infinity());
  else
    nearest_.assign(distances.begin(), distances.end());
  NearestDrawn nearest(nearest_, target.width(), target.height(),
                       float(render::RenderTarget::orthographic_error(view)));
  const NearAndFar range(view);
  std::erase_if(squares_, [&](const Square& square) {
    const float side = side_of(square, fixed_side);
    if (!nearest.shows(square, side)) return true;
    if (view.sections.empty() && snapshot.opaque(square.slot) && range.contain(square.distance))
      nearest.add(square, side);
    return false;
  });
  std::erase_if(squares_, [&](const Square& square) { return !nearest.shows(square, side_of(square, fixed_side)); });
}

core::Expected<void> SmallItems::draw(const gl::Context& context, const core::View& view,
                                      const core::Snapshot& snapshot, const culling::ContributionTest& test,
                                      const core::VisibleSet& visible, culling::SlotBits large, const Rule& rule,
                                      std::span<const float> distances, const gpuscene::GpuScene& scene,
                                      const render::RenderTarget& target) {
  using SquareRule = culling::ContributionTest::SquareRule;
  if (!points_) {
    auto points = render::PointSplats::create(context, target.format());
    if (!points) return tl::unexpected(points.error());
    points_ = std::move(*points);
  }
  const bool one_sample = target.format().samples == 1, stochastic = rule.way == ContributionWay::kStochastic;
  const float fixed_side = stochastic ? std::sqrt(rule.threshold) : 0.0f;
  test.squares(snapshot.bounds(), visible, large, stochastic ? rule.threshold : 0.0f,
               one_sample ? SquareRule::kOnPixelCentres : SquareRule::kAll, squares_);
  if (stochastic)
    std::erase_if(squares_, [&](const Square& square) {
      return !in_share(snapshot.item(square.slot), square.area / rule.threshold);
    });
  if (one_sample) leave_out_hidden(view, snapshot, fixed_side, distances, target);
  const Unprojection unprojection(view, target.width(), target.height());
  splats_.clear();
  for (const Square& square : squares_)
    splats_.push_back({unprojection.eye(square), std::min(side_of(square, fixed_side), points_->largest_side()),
                       snapshot.item(square.slot), gpuscene::GpuScene::material_row(snapshot, square.slot)});
  return points_->draw(view, splats_, scene, target);
}

}  // namespace sightline::engine
