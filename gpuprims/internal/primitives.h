// All analytic primitives behind one call.
#pragma once

#include "sightline/gpuprims/internal/tessellation.h"

namespace sightline::gpuprims {

/// Crossings of the ray's full line with any primitive, in rising t, as each kind's own header says. A line has none.
/// Rays and parameters that are not finite give no hits.
Hits intersect(const core::Primitive& primitive, const Ray& ray, Caps caps = {});

/// Triangles of any primitive, as tessellation.h promises. A line has none. Each kind's own header says what caps mean;
/// kinds without ends ignore them.
core::Mesh tessellate(const core::Primitive& primitive, const Tessellation& config = {}, Caps caps = {});

}  // namespace sightline::gpuprims
