// The cylinder: reference intersection and tessellation.
#pragma once

#include "sightline/gpuprims/tessellation.h"

namespace sightline::gpuprims {

/// Crossings of the ray's full line with the surface, in rising t. A closed cylinder has 0 or 2: it is convex. Height 0
/// is a disc of two sides at one t (the side facing the ray first), radius 0 is nothing. An open end drops its
/// crossing.
///
/// Half-chord form of the quadratic about the point closest to the axis: with unit direction u and origin o, u_xy and
/// o_xy their parts across the axis, the line passes the axis at distance q = |o_xy x u_xy| / |u_xy| at s = -o_xy.u_xy
/// / |u_xy|^2 and cuts sqrt(r^2 - q^2) / |u_xy| to both sides; see local_ray.h for the sources.
template <class Real = double>
Hits intersect(const core::Cylinder& cylinder, const Ray& ray, Caps caps = {});

core::Mesh tessellate(const core::Cylinder& cylinder, const Tessellation& config = {}, Caps caps = {});

}  // namespace sightline::gpuprims
