// Views in which many boxes fill the image.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "sightline/core/aabb.h"
#include "sightline/core/api.h"
#include "sightline/core/item_bounds.h"
#include "sightline/core/view.h"

namespace sightline::core {

/// Finds the view along a direction that shows boxes as large as possible. Unlike fitting_pose() of one box about all,
/// it leaves no room for empty corners of that box. Two opposite borders are touched. Between the other two the boxes
/// are centred within 2 % of the image, a single box exactly. Keeps a few extreme corners, whatever the number of
/// boxes.
class SIGHTLINE_API Fitting {
 public:
  /// As in fitting_pose(). `middle`: near the boxes, so that rounding is as small as they are.
  Fitting(const dvec3& direction, double fovy, double aspect, double filled, const dvec3& middle);

  /// `box`: in the world, finite; an empty one counts for nothing.
  void add(const AabbD& box);
  bool empty() const { return bounds_.empty(); }

  /// The pose of a perspective view from as near as possible: fitting_pose(), with the corners of all boxes.
  Pose pose() const;
  /// pose() with near and far plane as View::fit() has them. Fails where nothing was added.
  Expected<View> perspective() const;
  /// The parallel view in which the boxes touch two opposite borders and are centred between the others. Its eye is
  /// their diagonal away from the middle, and they lie between near and far plane. Fails where nothing was added.
  Expected<View> parallel() const;
  /// The pose of that view, its eye so far from the target that a perspective view would have its height there.
  /// Something must have been added.
  Pose parallel_pose() const;

 private:
  /// The corner farthest along `normal`, which is one of the eye's axes, right or up, less a slope times forward.
  struct Support {
    dvec3 normal, sides;  // sides: its components' absolute values
    double distance;
    dvec3 corner;  // in the eye's axes, from the middle
  };
  static constexpr std::size_t kSlopes = 5;
  dvec3 in_eye(const dvec3& p) const { return {glm::dot(p, right_), glm::dot(p, up_), glm::dot(p, forward_)}; }
  double centre(int axis, double depth) const;
  Pose looking_at(const dvec3& target, double distance) const;
  struct ParallelImage {
    dvec3 target;
    double height, diagonal;
  };
  ParallelImage parallel_image() const;

  double fovy_, aspect_, filled_, tangent_;
  dvec3 middle_, right_, up_, forward_;
  AabbD bounds_;
  std::size_t count_ = 0;
  std::array<dvec3, 8> corners_;               // of the first box, in the eye's axes, from the middle
  double nearest_, farthest_;                  // along `forward`, from the middle
  std::array<Support, 4 * kSlopes> supports_;  // by axis, side and slope
};

/// Adds the boxes of items that lie within a box whole, as far as section planes along the world's axes keep them, and
/// that are on any of `layers`.
SIGHTLINE_API void add_items(Fitting& fitting, const ItemBounds& items, const AabbD& within,
                             std::span<const Plane> sections = {}, std::uint32_t layers = kDefaultLayerMask);

/// A fitting about what sections keep of the items that lie wholly within a box (add_items()); about all these items
/// where sections keep nothing, about the box where no item lies within it, and about a cube where that is empty or a
/// point. So it is never empty. The arguments must be as fitting_pose() has them.
SIGHTLINE_API Fitting fitting_of(const ItemBounds& items, const AabbD& within, const dvec3& direction, double fovy,
                                 double aspect, std::span<const Plane> sections = {}, double filled = kOverviewFilled);

/// View::fit() of the items that lie within a box whole, instead of the box: they are shown as large as possible. Fails
/// as that does, and is the same where no item lies within.
SIGHTLINE_API Expected<View> fit_items(const ItemBounds& items, const AabbD& within, const dvec3& direction,
                                       double fovy, double aspect, double filled = kOverviewFilled);

}  // namespace sightline::core
