// The cap of a sphere: reference intersection and tessellation.
#pragma once

#include "sightline/gpuprims/internal/tessellation.h"

namespace sightline::gpuprims {

/// Crossings of the ray's full line with the surface, in rising t: 0 or 2 when closed, since the dish is convex.
/// caps.bottom is the base; there is no top. Height 0 (or below 1e-18 radii) is a two-sided disc with both crossings at
/// one t; without its base it has only the upper one. Base radius 0 is the whole ball above z = 0, and both 0 are
/// nothing. The quadratic: see dome.h.
Hits intersect(const core::SphericalDish& dish, const Ray& ray, Caps caps = {});

/// Rings at equal angles of the sphere's meridian; caps.bottom is the base, there is no top. With a height above its
/// base radius it is more than half a sphere. Base radius 0 with a height is the whole sphere of that diameter.
core::Mesh tessellate(const core::SphericalDish& dish, const Tessellation& config = {}, Caps caps = {});

}  // namespace sightline::gpuprims
