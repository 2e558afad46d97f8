// A scene whose analytic primitives have become triangles: what a viewer without ray-casting would draw.
#pragma once

#include "sightline/core/scene.h"

namespace sightline::bench {

/// The same nodes, materials, meshes and items under the same item ids, but each primitive is an instance of a mesh
/// with `segments` (>= 3) per full circle. Equal parameters share one mesh. Lines stay lines. Names and attributes are
/// kept; node and mesh handles of the given scene mean nothing in the result.
core::Scene tessellated(const core::Scene& scene, int segments);

}  // namespace sightline::bench
