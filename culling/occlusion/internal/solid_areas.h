// Mean areas that items show, by slot: what contribution is measured by beside bounding boxes. Internal to culling and
// engine.
#pragma once

#include <span>
#include <vector>

#include "sightline/core/internal/deadline.h"
#include "sightline/core/snapshot.h"

namespace sightline::culling {

/// Mean area that an item shows over all directions, square metres: of a convex solid a quarter of its surface (A.
/// Cauchy, 1832). That of tori and meshes is too large, as they are not convex, and that of an open mesh, both of whose
/// sides show, up to half of what it should be. Slanted ends of snouts count as straight, scaling by different factors
/// as scaling by their mean. Infinity where the placement is singular, so that the bounding box limits it.
float mean_projected_area(const core::Snapshot& snapshot, core::Slot slot);

/// Costs nothing before the first of(). From then on four bytes per slot.
class SolidAreas {
 public:
  /// mean_projected_area() of all slots, 0 where they are vacant.
  std::span<const float> of(const core::Snapshot& snapshot);
  /// Begins what the next of() would do, and pauses when the deadline is over. True once nothing is left of it.
  bool measure(const core::Snapshot& snapshot, core::Deadline deadline);
  /// Follows an edit of the snapshot: Drawing::update().
  void update(const core::Snapshot& snapshot, std::span<const core::Slot> touched);
  /// Forgets them: another order of the items.
  void reset() { areas_.clear(); }

 private:
  std::vector<float> areas_;
};

}  // namespace sightline::culling
