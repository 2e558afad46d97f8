// All analytic primitives behind one call.
#pragma once

#include "sightline/gpuprims/internal/tessellation.h"

namespace sightline::gpuprims {

/// Crossings of the ray's full line with any primitive, in rising t, as each kind's own header says. A line has none.
/// Rays and parameters that are not finite give no hits. Real, double or float, is the type that the primitive's own
/// part computes in. In both cases the ray is moved into the primitive's neighbourhood in double, and t is returned in
/// double.
template <class Real = double>
Hits intersect(const core::Primitive& primitive, const Ray& ray, Caps caps = {});

/// Triangles of any primitive, as tessellation.h promises. A line has none. Each kind's own header says what caps mean;
/// kinds without ends ignore them.
core::Mesh tessellate(const core::Primitive& primitive, const Tessellation& config = {}, Caps caps = {});

}  // namespace sightline::gpuprims
