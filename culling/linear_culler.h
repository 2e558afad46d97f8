// Frustum culling without a hierarchy: every box, every view. Fastest for small scenes, and the twin that every other
// culler is measured against.
#pragma once

#include <cstddef>

#include "sightline/core/item_bounds.h"
#include "sightline/core/view.h"
#include "sightline/core/visible_set.h"
#include "sightline/culling/frustum_test.h"

namespace sightline::culling {

/// Promise: conservative (see CullPlanes). An item is visible when its box is not empty, passes the planes, and shares
/// a layer with the view.
class LinearCuller {
 public:
  /// Borrows the bounds, which must outlive the culler. They may change between calls.
  explicit LinearCuller(const core::ItemBounds& bounds) : bounds_(&bounds) {}

  /// Replaces the contents of `set`. Does not allocate once `set` has grown to its size.
  void cull(const core::View& view, core::VisibleSet& set) const;

 private:
  const core::ItemBounds* bounds_;
};

/// Appends the visible ones of slots first … end - 1 to `set`, whose slots all lie before them, and counts them as
/// tested: groups of kLanes from `first` on that are wholly visible as ranges, others as single slots. `layers`: the
/// view's.
void cull_slots(const core::ItemBounds& bounds, const CullPlanes& planes, PlaneMask mask, std::uint32_t layers,
                std::size_t first, std::size_t end, core::VisibleSet& set);

}  // namespace sightline::culling
