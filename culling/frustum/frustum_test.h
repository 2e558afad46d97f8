// Boxes against the planes of a view: conservative, and one answer for every caller.
//
// The view volume is the closed set of points that satisfy the six planes of View::clip_from_world() (taken exactly
// from its sixteen doubles) and the view's section planes. These are moved outwards by the rounding of items as large
// as the extent (core/internal/section_rounding.h), so that what touches one is kept. A box is tested plane by plane
// through its p-vertex, the corner farthest along the plane's normal; the n-vertex, the opposite corner, tells whether
// the box lies wholly inside (U. Assarsson, T. Möller, "Optimized view frustum culling algorithms for bounding boxes",
// 2000).
//
// Two stages. Planes are built in double, moved to the bounds' origin, scaled by a power of two and rounded to float.
// Everywhere the same expression is evaluated, in float and in this order, at a corner c:
//     s(c) = ((nx * cx + ny * cy) + nz * cz) + d
// Each plane has a band B that exceeds every error between s and the exact value of the exact plane (derived in
// frustum_test.cpp). A box is
//     surely outside  when s(p-vertex) < -B,
//     surely passing  when s(p-vertex) >= B,
// and an item between the two is decided in double, again on the side of drawing it. Nodes of a hierarchy are never
// looked at in double: they are rejected only when surely outside, and free of a plane only when s(n-vertex) >= B.
//
// Why a hierarchy answers exactly what a linear pass answers. Rounding to nearest is monotone, so every product and sum
// above is monotone in its operands (n is fixed; a contracted multiply-add would be another expression, hence
// -ffp-contract=off), and so is s in the box: for a box P around a box C, s(p-vertex of P) >= s(p-vertex of C) and
// s(n-vertex of P) <= s(n-vertex of C) <= s(p-vertex of C) *as computed*.
//   1. A node is rejected by a plane: s(p) < -B, so s(p) < -B for every item below: each is rejected alone, too.
//   2. A node is free of a plane: s(n) >= B, so s(p) >= B for every item below: each passes the plane alone, too.
//   3. Otherwise the plane is tested again further down, at last on the items themselves.
// The decision in double concerns only items between the two cases, for which neither 1 nor 2 can have happened. For a
// union of section planes the same holds with "all planes reject" in 1 and "one plane is passed" in 2.
// Comparisons with NaN are false, so a NaN (from whatever cause) neither rejects nor frees: the box is kept.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "sightline/core/api.h"
#include "sightline/core/item_bounds.h"
#include "sightline/core/view.h"

namespace sightline::culling {

/// Set of planes still to be tested: one bit per plane, and one bit for the union of section planes as a whole.
using PlaneMask = std::uint32_t;

inline constexpr int kMaxCullPlanes = core::kFrustumPlaneCount + int(core::kMaxSectionPlanes);
inline constexpr PlaneMask kUnionPlanes = PlaneMask(1) << kMaxCullPlanes;

/// Float form of a plane. A test needs no more as long as the answer is clear.
struct FloatPlane {
  float normal[3];
  float offset;
  float band;              // B: every error of the float value is smaller
  std::uint8_t p_axis[3];  // coordinate arrays (0 … 5) of the p-vertex
  std::uint8_t n_axis[3];  // of the n-vertex
};

/// The planes of one view, prepared for boxes of one ItemBounds: valid while neither the bounds' origin changes nor its
/// extent grows. Promise: conservative. A box that meets the view volume is never outside; a box is kept needlessly
/// only when, for every plane, the exact value at the p-vertex is above -2e-15 times the sum of the absolute terms that
/// enter it (matrices whose entries lie hundreds of orders of magnitude apart under- or overflow, and keep more).
/// Planes that are not finite are dropped (more is drawn, never less); section planes without a normal are ignored; a
/// frustum plane without one is met everywhere or nowhere.
class SIGHTLINE_API CullPlanes {
 public:
  CullPlanes(const core::View& view, const core::ItemBounds& bounds);

  /// True when no box can be visible anywhere: a plane that must be met is out of reach.
  bool nothing_visible() const { return nothing_visible_; }
  /// All planes: the mask to start with. 0 when there is nothing to test.
  PlaneMask all() const { return all_; }

  /// Items: whether the box passes the planes of `mask`. Inverted (empty) boxes are never visible.
  bool visible(const core::Aabb& box, PlaneMask mask) const;
  /// Nodes: true when nothing within this box is visible.
  bool outside(const core::Aabb& box, PlaneMask mask) const;
  /// Nodes: the planes of `mask` that boxes within it must still be tested against.
  PlaneMask remaining(const core::Aabb& box, PlaneMask mask) const;

  /// For the kernels, which do the same to sixteen boxes at a time. Planes from union_first() on form the union.
  const FloatPlane* planes() const { return planes_.data(); }
  int plane_count() const { return count_; }
  int union_first() const { return union_first_; }

 private:
  /// Double form, for items that the float form leaves open.
  struct DoublePlane {
    double normal[3];
    double offset;
    double magnitude;  // of what entered the offset: sum of |n_i o_i|, and |d|
    double tiny;       // bound for all underflow
  };
  enum class Kind : std::uint8_t { kPlane, kNoNormal, kAlways, kNever, kUnusable };
  struct Sizes;

  Kind add(const core::Plane& plane, const Sizes& sizes);
  void add_frustum(const core::View& view, const Sizes& sizes);
  void add_sections(const core::View& view, const Sizes& sizes);
  bool passes(int plane, const core::Aabb& box) const;
  bool passes_in_double(int plane, const core::Aabb& box) const;

  std::array<FloatPlane, kMaxCullPlanes> planes_;
  std::array<DoublePlane, kMaxCullPlanes> exact_;
  int union_first_ = 0, count_ = 0;  // planes [union_first_, count_) form the union
  PlaneMask all_ = 0;
  bool nothing_visible_ = false;
};

}  // namespace sightline::culling
