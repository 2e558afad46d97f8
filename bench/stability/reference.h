// The stability suite's judge: crossings of a line with a solid in arithmetic of 113 bits, straight from the definition
// in core/primitive.h, and written apart from gpuprims. Parameters are floats, frames and rays doubles: all are taken
// as exact.
//
// A solid is the points at which an implicit condition holds, its boundary part of a few surfaces f(x, y, z) = 0 with f
// a polynomial. Along a line each f is a polynomial in one variable; all its roots are isolated between those of its
// derivatives; and the line crosses the boundary where the condition holds on one side of a root and not on the other.
#pragma once

#include <vector>

#include "sightline/bench/stability/quad.h"
#include "sightline/core/affine.h"
#include "sightline/core/primitive.h"
#include "sightline/gpuprims/internal/ray.h"

namespace sightline::bench {

/// Faces by number, as the shaders count them: round or lateral ones, bottom or start, top or end. Boxes and pyramids
/// count their four sides as lateral.
enum Face : int { kLateral, kBottom, kTop };

struct Crossing {
  Quad t = 0;               ///< of the given ray
  core::dvec3 normal{0.0};  ///< outward, unit length, in the item's frame; zero where there is none (an apex)
  int face = kLateral;
};

/// A ray in an item's frame.
struct QuadRay {
  QuadVec origin, direction;
};

/// `ray` is in the world; its parameter stays. A singular frame gives a direction of zero, which crosses nothing.
QuadRay in_item_frame(const core::Affine& world_from_item, const gpuprims::Ray& ray);

/// All crossings in rising t: an even number, none for what is not finite, for a ray without direction, and for a
/// solid without volume, but for the flat forms which gpuprims gives two sides: they have two crossings at one t.
std::vector<Crossing> reference_crossings(const core::Primitive& primitive, const QuadRay& ray);

/// What the rays parallel to one cross that pass it at `band` (in the item's units) and at a quarter of it, in sixteen
/// directions each: how the answer depends on what nobody can resolve.
using Neighbours = std::vector<std::vector<Crossing>>;
Neighbours neighbours(const core::Primitive& primitive, const QuadRay& ray, double band);

/// Whether a ray with these crossings lies within the band of a tie: a neighbour crosses another number of times or
/// other faces. Tangents, rims, seams and edges are such.
bool near_tie(const std::vector<Crossing>& crossings, const Neighbours& neighbours);

/// Largest angle (radians) between a crossing's normal and that of a neighbour that crosses as often: large at an apex.
double normal_spread(const std::vector<Crossing>& crossings, const Neighbours& neighbours);

/// Between directions, precise for small ones; 0 where `expected` is zero.
double angle_between(const core::dvec3& found, const core::dvec3& expected);

}  // namespace sightline::bench
