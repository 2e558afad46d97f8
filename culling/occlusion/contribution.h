// Contribution: how large an item is in the image, and culling by that. The only culling here that loses something.
//
// The measure is the number of samples that an item is expected to cover, with one sample per pixel: an area, in
// pixels.
//
//     area = min(area of the box's outline, solid area x pixels of a square metre that faces the eye at the box's
//     centre)
//
// The outline is the convex one of the projected box: half the sum of the areas of its six projected faces (each of its
// points lies in the projections of two). Alone it is too large for what stands askew or is hollow, as pipes and elbows
// are. So the caller may give each slot a solid area in square metres, such as the mean that the item shows over all
// directions. That of a convex solid is a quarter of its surface (A. Cauchy, 1832), and half of what it shows from any
// direction or more. A diagonal or bounding sphere instead is large for a long thin pipe, of which nearly nothing
// shows.
//
// A box inside another one has the smaller outline, so one look at a leaf of the hierarchy may decide for all of its
// items.
//
// Promise: approximate; areas are off by less than a thousandth and by less than 0.001 pixels. Lines, which are drawn
// one pixel wide whatever their box, should be exempt.
//
// Hysteresis: an item that was kept stays until it is smaller than kHysteresis of the threshold. So no item flickers
// while the camera trembles.
#pragma once

#include <limits>
#include <span>
#include <vector>

#include "sightline/core/api.h"
#include "sightline/core/item_bounds.h"
#include "sightline/core/view.h"
#include "sightline/core/visible_set.h"
#include "sightline/culling/frustum/hierarchy.h"
#include "sightline/culling/occlusion/detail/screen_view.h"
#include "sightline/culling/occlusion/sample_test.h"

namespace sightline::culling {

class SIGHTLINE_API ContributionTest {
 public:
  static constexpr float kHysteresis = 0.8f;

  /// `origin`: of the bounds whose boxes will be measured. width, height: of the image, in pixels. `solids`: by slot,
  /// square metres, 0 or more; infinity where only the box is known, as it is of slots beyond the last. Borrowed.
  ContributionTest(const core::View& view, const core::dvec3& origin, int width, int height,
                   std::span<const float> solids = {});

  /// In pixels, beyond the image's edges included. Infinity for boxes that reach behind the eye; 0 for empty ones.
  float area(const core::Aabb& box, float solid = std::numeric_limits<float>::infinity()) const;

  struct SlotArea {
    core::Slot slot;
    float area;
  };
  /// Replaces `areas` by the slots of `in` with their areas. Vacant slots are left out.
  void areas(const core::ItemBounds& bounds, const core::VisibleSet& in, std::vector<SlotArea>& areas) const;

  /// Replaces `kept` by the slots of `in` with an area of `threshold` or more, or of kHysteresis times that where
  /// `before` has a bit, or with a bit in `exempt`. Vacant slots are left out.
  void filter(const core::ItemBounds& bounds, const core::VisibleSet& in, float threshold, core::VisibleSet& kept,
              SlotBits before = {}, SlotBits exempt = {}) const;
  /// A first, coarse step for large sets: leaves out those leaves of the hierarchy that lie within ranges of `in` and
  /// are smaller than kHysteresis times the threshold. `hierarchy`: over the bounds that `in` belongs to.
  void filter_leaves(const Hierarchy& hierarchy, const core::VisibleSet& in, float threshold, core::VisibleSet& kept,
                     SlotBits exempt = {}) const;

  /// What may stand for an item: a square of its area around the projected centre of its box.
  struct Splat {
    core::Slot slot;
    float x, y;      ///< of the centre, pixels; the first pixel's centre, at the lower left, is at 0
    float distance;  ///< of the centre along the viewing direction, metres
    float area;      ///< pixels
  };
  enum class SplatRule { kOnPixelCentres, kAll };
  /// Replaces `splats` by those of the slots of `in` without a bit in `without` whose centres are in the image; with
  /// kOnPixelCentres only those that may cover a pixel centre. Those smaller than
  /// `least_area`, in pixels, will be drawn that large. There are none of boxes that reach behind the eye.
  void splats(const core::ItemBounds& bounds, const core::VisibleSet& in, SlotBits without, float least_area,
              SplatRule rule, std::vector<Splat>& splats) const;

 private:
  unsigned at_least(const float* const (&coordinates)[6], const float* solids, float threshold,
                    float (&areas)[kLanes]) const;

  ScreenView view_;
  std::span<const float> solids_;
};

}  // namespace sightline::culling
