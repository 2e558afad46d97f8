// All analytic primitives behind one call.
#pragma once

#include "sightline/gpuprims/internal/tessellation.h"

namespace sightline::gpuprims {

/// Crossings of the ray's full line with any primitive, in rising t, as each kind's own header says. A line has none.
/// Undefined rays and parameters (not finite) hit nothing. Real is what the primitive's own part computes in, double or
/// float; the ray is moved into its neighbourhood in double either way, and t comes back in double.
template <class Real = double>
Hits intersect(const core::Primitive& primitive, const Ray& ray, Caps caps = {});

/// Triangles of any primitive, as tessellation.h promises. A line has none. Caps mean what each kind's own header says;
/// kinds without ends ignore them.
core::Mesh tessellate(const core::Primitive& primitive, const Tessellation& config = {}, Caps caps = {});

}  // namespace sightline::gpuprims
