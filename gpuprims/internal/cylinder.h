// The cylinder: reference intersection and tessellation.
#pragma once

#include "sightline/gpuprims/internal/tessellation.h"

namespace sightline::gpuprims {

/// Crossings of the ray's full line with the surface, in rising t. A closed cylinder has 0 or 2, since it is convex.
/// Height 0 is a two-sided disc with both crossings at one t (the side facing the ray first); radius 0 is nothing. An
/// open end drops its crossing.
///
/// Half-chord form of the quadratic about a point close to the cylinder (see local_ray.h). With o and u the parts of
/// origin and direction across the axis, the crossings lie sqrt(r^2 u.u - (o x u)^2) / u.u to both sides of s = -o.u /
/// u.u.
Hits intersect(const core::Cylinder& cylinder, const Ray& ray, Caps caps = {});

core::Mesh tessellate(const core::Cylinder& cylinder, const Tessellation& config = {}, Caps caps = {});

}  // namespace sightline::gpuprims
