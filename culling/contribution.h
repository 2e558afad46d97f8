// Contribution: how large an item is in the picture, and culling by that. The only culling here that loses something.
//
// The measure is the projected area of an item's bounding box, in pixels: of the box's convex outline, half the sum of
// the areas of its six projected faces (each of its points lies in the projections of two). Unlike a bounding sphere or
// a diagonal it is small for the thin box of a long pipe. A box inside another one has the smaller area, so one look at
// a leaf of the hierarchy may decide for all of its items.
//
// Promise: approximate; areas are off by less than a thousandth and by less than 0.001 pixels. Lines, which are drawn
// one pixel wide whatever their box, should be exempt.
//
// Hysteresis: an item that was kept stays until it is smaller than kHysteresis of the threshold. So no item flickers
// while the camera trembles.
#pragma once

#include <vector>

#include "sightline/core/api.h"
#include "sightline/core/item_bounds.h"
#include "sightline/core/view.h"
#include "sightline/core/visible_set.h"
#include "sightline/culling/hierarchy.h"
#include "sightline/culling/internal/screen_view.h"
#include "sightline/culling/sample_test.h"

namespace sightline::culling {

class SIGHTLINE_API ContributionTest {
 public:
  static constexpr float kHysteresis = 0.8f;

  /// `origin`: of the bounds whose boxes will be measured. width, height: of the picture, in pixels.
  ContributionTest(const core::View& view, const core::dvec3& origin, int width, int height);

  /// In pixels, beyond the picture's edges included. Infinity for boxes that reach behind the eye; 0 for empty ones.
  float area(const core::Aabb& box) const;

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

 private:
  unsigned at_least(const float* const (&coordinates)[6], float threshold, float (&areas)[kLanes]) const;

  ScreenView view_;
};

}  // namespace sightline::culling
