// The normal by which renderers light what a ray hits. Internal to raytrace.
#pragma once

#include "sightline/raytrace/tracer.h"

namespace sightline::raytrace {

/// Of unit length, in the world, and towards where a ray of this direction comes from. Where a mesh has normals it is
/// the mean of the triangle's, otherwise the surface's own.
core::dvec3 shading_normal(const core::Snapshot& snapshot, const Hit& hit, const core::dvec3& direction);

}  // namespace sightline::raytrace
