// A scene whose analytic primitives are replaced by triangles, as a viewer without ray-casting would draw it.
#pragma once

#include "sightline/core/scene.h"

namespace sightline::apps {

/// A copy with equal nodes, materials, meshes and items of equal ids, but each primitive is an instance of a mesh with
/// `segments` (>= 3) per full circle. Equal parameters share one mesh. Lines stay lines. Names and attributes are kept.
/// Node and mesh handles of the given scene are not valid in the result.
core::Scene tessellated(const core::Scene& scene, int segments);
/// A copy with triangles within `metres` (> 0) of the surfaces in the world, but at most 256 segments per full circle.
core::Scene tessellated_within(const core::Scene& scene, double metres);

}  // namespace sightline::apps
