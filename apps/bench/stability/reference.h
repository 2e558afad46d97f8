// The reference of the stability suite: crossings of a line with a solid in arithmetic of 113 bits. It follows the
// definition in core/primitive.h and shares no code with gpuprims. Parameters are floats, frames and rays doubles; all
// are taken as exact.
//
// A solid is the set of points where an implicit condition holds. Its boundary is part of a few surfaces f(x, y, z) =
// 0, where f is a polynomial. Along a line each f is a polynomial in one variable, and all its roots are isolated
// between those of its derivatives. The line crosses the boundary at a root where the condition holds on one side and
// not on the other.
#pragma once

#include <memory>
#include <vector>

#include "sightline/apps/bench/stability/quad.h"
#include "sightline/core/affine.h"
#include "sightline/core/primitive.h"
#include "sightline/gpuprims/internal/ray.h"

namespace sightline::bench {

// Faces are kSide, kBottom and kTop alone: the four sides of boxes and pyramids count as kSide.
using enum core::Face;

struct Crossing {
  Quad t = 0;               ///< of the given ray
  core::dvec3 normal{0.0};  ///< outward, unit length, in the item's frame; zero where undefined (an apex)
  int face = kSide;
};

/// A ray in an item's frame.
struct QuadRay {
  QuadVec origin, direction;
};

/// `ray` is in the world; its parameter stays the same. A singular frame gives a zero direction, which crosses nothing.
QuadRay in_item_frame(const core::Affine& world_from_item, const core::Ray& ray);

/// All crossings in rising t: an even number. None for numbers that are not finite, for a ray without direction, and
/// for a solid without volume. The exceptions are flat forms that gpuprims gives two sides: they have two crossings at
/// one t.
std::vector<Crossing> reference_crossings(const core::Primitive& primitive, const QuadRay& ray);

/// Crossings of many rays with one solid, whose surfaces are made once.
class ReferenceSolid {
 public:
  explicit ReferenceSolid(const core::Primitive& primitive);
  std::vector<Crossing> crossings(const QuadRay& ray) const;

 private:
  struct Surfaces;
  std::shared_ptr<const Surfaces> surfaces_;  // null: nothing to cross
  Quad reach_ = 0;
};

/// Crossings of rays parallel to one ray, at distance `band` (in the item's units) and at a quarter of it, in sixteen
/// directions each. They show how the result depends on differences that nobody can resolve.
using Neighbours = std::vector<std::vector<Crossing>>;
Neighbours neighbours(const ReferenceSolid& solid, const QuadRay& ray, double band);
inline Neighbours neighbours(const core::Primitive& primitive, const QuadRay& ray, double band) {
  return neighbours(ReferenceSolid(primitive), ray, band);
}

/// Whether a ray with these crossings lies within the band of a tie: a neighbour has another number of crossings or
/// crosses other faces. That happens at tangents, rims, seams and edges.
bool near_tie(const std::vector<Crossing>& crossings, const Neighbours& neighbours);

/// Largest angle (radians) between a crossing's normal and that of a neighbour with as many crossings: large at an
/// apex.
double normal_spread(const std::vector<Crossing>& crossings, const Neighbours& neighbours);

/// Angle between directions, precise for small angles; 0 if `expected` is zero.
double angle_between(const core::dvec3& found, const core::dvec3& expected);

}  // namespace sightline::bench
