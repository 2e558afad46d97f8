// The sphere: reference intersection and tessellation.
#pragma once

#include "sightline/gpuprims/internal/tessellation.h"

namespace sightline::gpuprims {

/// Crossings of the ray's full line with the surface, in rising t: 0 or 2. Diameter 0 is nothing. Caps are ignored.
/// Half-chord form about the point closest to the centre; see dome.h.
Hits intersect(const core::Sphere& sphere, const Ray& ray, Caps caps = {});

/// By latitude and longitude. A sphere has no ends: caps are ignored.
core::Mesh tessellate(const core::Sphere& sphere, const Tessellation& config = {}, Caps caps = {});

}  // namespace sightline::gpuprims
