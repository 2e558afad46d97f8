// Spatial queries for applications: items in a box, around a point, along a ray, nearest to a point. They test the
// items' boxes through the culler's hierarchy. Time grows with the answer and not with the scene.
//
// An item's box is bounds.origin + its float box, in real numbers. It is closed, and it contains the item's true box,
// since it was rounded outwards. Queries are in world metres and double. Promise: an item whose true box meets a query
// is reported. Box ranges are answered exactly for the float boxes. Spheres, rays and distances are computed in double
// with a relative error below 4e-15, on the side of reporting (derived in spatial_queries.cpp). The answer does not
// depend on the hierarchy.
//
// Items without a box (empty) or without a layer in common with `layers` are never reported. No box may hold a NaN.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "sightline/core/api.h"
#include "sightline/core/item_bounds.h"
#include "sightline/core/ray.h"
#include "sightline/culling/frustum/hierarchy.h"

namespace sightline::culling {

struct SlotDistance {
  core::Slot slot;
  double distance;
  friend bool operator==(const SlotDistance&, const SlotDistance&) = default;
};

/// Borrows bounds and a hierarchy over their first slots. Both must outlive it, and the hierarchy must have been
/// refitted to changed boxes. Slots beyond the hierarchy are tested one by one. Every query replaces the contents of
/// the vector that it is given. It does not allocate once that vector and the thread's scratch memory have grown to
/// their sizes. Several threads may query at once.
///
/// Points and directions must be finite with components below 1e150; a range may be infinite. Any other query (NaN, an
/// empty range, a negative radius, t_min > t_max) finds nothing.
class SIGHTLINE_API SpatialQueries {
 public:
  SpatialQueries(const core::ItemBounds& bounds, const Hierarchy& hierarchy)
      : bounds_(&bounds), hierarchy_(&hierarchy) {}

  /// Items whose box shares a point with `range`, in rising order.
  void intersecting(const core::AabbD& range, std::uint32_t layers, std::vector<core::Slot>& slots) const;
  /// Items whose float box lies within `range`, in rising order. The true box of each lies within it, too. An item is
  /// missing where only the rounding of its float box reaches out of `range`.
  void inside(const core::AabbD& range, std::uint32_t layers, std::vector<core::Slot>& slots) const;
  /// Items whose box comes within `radius` metres of `point`, in rising order.
  void around(const core::dvec3& point, double radius, std::uint32_t layers, std::vector<core::Slot>& slots) const;

  /// Items whose box the ray meets, in rising order, each with the t at which it enters (t_min when it starts inside).
  /// Components of the direction below 1e-150 count as zero; with all zero the ray is a point.
  void along(const core::Ray& ray, std::uint32_t layers, std::vector<SlotDistance>& hits) const;
  /// The first `count` of these items, front to back; items with equal t in order of slots.
  void first_along(const core::Ray& ray, std::size_t count, std::uint32_t layers,
                   std::vector<SlotDistance>& hits) const;

  /// The `count` items nearest to `point`, nearest first, with the distances of their boxes in metres (0 inside);
  /// equally far items in order of slots.
  void nearest(const core::dvec3& point, std::size_t count, std::uint32_t layers,
               std::vector<SlotDistance>& hits) const;

 private:
  const core::ItemBounds* bounds_;
  const Hierarchy* hierarchy_;
};

}  // namespace sightline::culling
