// Frustum culling without a hierarchy: tests every box for every view. Fastest for small scenes, and the reference that
// every other culler is compared with.
#pragma once

#include <cstddef>

#include "sightline/core/api.h"
#include "sightline/core/item_bounds.h"
#include "sightline/core/view.h"
#include "sightline/core/visible_set.h"
#include "sightline/culling/frustum/frustum_test.h"

namespace sightline::culling {

/// Promise: conservative (see CullPlanes). An item is visible when its box is not empty, passes the planes, and shares
/// a layer with the view.
class SIGHTLINE_API LinearCuller {
 public:
  /// Borrows the bounds, which must outlive the culler. They may change between calls.
  explicit LinearCuller(const core::ItemBounds& bounds) : bounds_(&bounds) {}

  /// Replaces the contents of `set`. Does not allocate once `set` has grown to its size.
  void cull(const core::View& view, core::VisibleSet& set) const;

 private:
  const core::ItemBounds* bounds_;
};

/// Appends the visible ones of `slots` to `set` and counts all of these as tested. The set's present slots must all lie
/// before them. Groups of kLanes, counted from the first, that are wholly visible become ranges, other
/// visible slots single slots. `layers`: the view's.
SIGHTLINE_API void cull_slots(const core::ItemBounds& bounds, const CullPlanes& planes, PlaneMask mask,
                              std::uint32_t layers, core::SlotRange slots, core::VisibleSet& set);

}  // namespace sightline::culling
