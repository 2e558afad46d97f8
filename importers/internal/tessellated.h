// Internal to the writers of triangles: how finely a primitive is cut, and how far its triangles are from it.
#pragma once

#include "sightline/core/affine.h"
#include "sightline/core/mesh.h"

namespace sightline::importers {

/// Most segments of a full circle, whatever the tolerance.
inline constexpr int kMostSegments = 1024;

/// The largest stretch of the map: exact when its axes stay at right angles, else an upper bound.
double largest_scale(const core::dmat3& linear);

/// Largest height of the arcs over the edges, from the normals at their ends: exact for circles, an estimate to second
/// order elsewhere.
double chord_error(const core::Mesh& mesh);

/// Maps normals as `linear` maps positions: by the cofactors, which are the inverse transpose except for the
/// determinant. Results may have any length.
core::dmat3 normal_map(const core::dmat3& linear);

}  // namespace sightline::importers
