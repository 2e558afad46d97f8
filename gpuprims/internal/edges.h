// The edges of analytic primitives: where two of their faces meet, and where open ones end.
#pragma once

#include "sightline/core/affine.h"
#include "sightline/core/fixed_list.h"
#include "sightline/core/primitive.h"

namespace sightline::gpuprims {

/// All centre + cos(t) u + sin(t) v, 0 <= t <= sweep, in the world, metres. A straight edge has v = 0 and half a turn.
struct PrimitiveEdge {
  core::dvec3 centre{0.0}, u{0.0}, v{0.0};
  double sweep = core::kFullTurn;  ///< radians

  bool straight() const { return v == core::dvec3(0.0); }
};
using PrimitiveEdges = core::FixedList<PrimitiveEdge, 12>;

/// Exact up to double rounding. Rims are those that have an end_face() (joints.h). Spheres and closed tubes have no
/// edge, nor has a core::Line, which is drawn as it is. Edges without length are left out.
PrimitiveEdges edges_of(const core::Primitive& primitive, const core::Affine& world_from_item);

}  // namespace sightline::gpuprims
