// Occlusion: which boxes are hidden behind what is already drawn.
//
// Promise: conservative at the sample positions of one depth image. A box is hidden only when, at every pixel centre
// that its projection may contain, the image holds a distance that is less than that of any point of the box there.
// Whatever lies in the box then fails the depth test at each of these pixels. Boxes that reach behind the eye are never
// hidden.
//
// Two steps: first all pixels of the rectangle around the projection against the box's least distance, in the pyramid;
// then, for boxes that this leaves open, the ray of each pixel against the box itself (detail/ray_spans.h): of boxes
// of at most 64 pixels, a pixel of each of sixteen boxes at a time (internal/small_boxes.h); of larger ones, sixteen
// pixels of the box at a time, whole blocks first. Most boxes are decided sooner, sixteen of them at a time: one look
// at 2 x 2 blocks of the pyramid hides them, or the ray of one pixel meets them in front of what it holds.
//
// Where the distances come from does not matter: an image's own depth after a first pass, a raster of chosen
// occluders, or the application. They must be those of surfaces that are drawn, or larger. Section planes and
// transparency need no rule then: what is cut away or left out by a dither has left no distance. Distances may be
// rounded; kDistanceMargin is more than a float depth buffer and a shader's ray lose.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/api.h"
#include "sightline/core/item_bounds.h"
#include "sightline/core/thread_pool.h"
#include "sightline/core/view.h"
#include "sightline/core/visible_set.h"
#include "sightline/culling/frustum/hierarchy.h"
#include "sightline/culling/occlusion/depth_pyramid.h"
#include "sightline/culling/occlusion/detail/depth_test.h"
#include "sightline/culling/occlusion/sample_test.h"

namespace sightline::culling {

class SIGHTLINE_API OcclusionTest {
 public:
  /// A box is hidden when it is farther than the occluder by this share of the distance.
  static constexpr float kDistanceMargin = 0x1p-16f;

  /// `origin`: of the bounds whose boxes will be tested. Borrows the pyramid, which may be built anew between tests: of
  /// the distances of `view` in an image of width x height pixels, drawn by a rasteriser of that `snap`
  /// (rasteriser_snap). While it is of another size, or not built at all, nothing is hidden. They may also be off by
  /// `error` metres, as in orthographic views, whose depth is linear.
  OcclusionTest(const core::View& view, const core::dvec3& origin, int width, int height, const DepthPyramid& pyramid,
                double error = 0.0, float snap = kCoarsestSnap);

  /// Also true of boxes that cover no pixel centre.
  bool occluded(const core::Aabb& box) const;
  /// The least distance of a box along the viewing direction, but for rounding.
  float distance(const core::Aabb& box) const;

  /// Replaces `unoccluded` by the slots of `in` whose boxes are not hidden, or whose bit is set in `exempt`. Vacant
  /// slots are left out. Large sets are shared out among `threads`, if there are any. filter_leaves() comes first where
  /// there is a `hierarchy`.
  void filter(const core::ItemBounds& bounds, const core::VisibleSet& in, core::VisibleSet& unoccluded,
              SlotBits exempt = {}, core::ThreadPool* threads = nullptr, const Hierarchy* hierarchy = nullptr) const;
  /// A first, coarse step for large sets: leaves out those leaves of the hierarchy that lie within ranges of `in` and
  /// whose boxes, or those of nodes above, are hidden. `hierarchy`: over the bounds that `in` belongs to.
  void filter_leaves(const Hierarchy& hierarchy, const core::VisibleSet& in, core::VisibleSet& unoccluded,
                     SlotBits exempt = {}) const;

  /// Distributes the slots of `in` that are not hidden: `front` gets the box that the ray of each pixel enters first,
  /// and boxes too large to look at each of their pixels, or not judged. What is drawn next hides most if it is that.
  /// Where boxes are entered at the same distance, the one with the lower slot is first. `hierarchy`: as for
  /// filter_leaves(), or null. `threads`: as for filter().
  void split_front(const core::ItemBounds& bounds, const Hierarchy* hierarchy, const core::VisibleSet& in,
                   core::VisibleSet& front, core::VisibleSet& behind, core::ThreadPool* threads = nullptr) const;

 private:
  DepthTest depth_;
};

}  // namespace sightline::culling
