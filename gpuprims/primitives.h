// All analytic primitives behind one call.
#pragma once

#include "sightline/gpuprims/tessellation.h"

namespace sightline::gpuprims {

/// Triangles of any primitive, as tessellation.h promises. A line has none. Caps mean what each kind's own header says;
/// kinds without ends ignore them.
core::Mesh tessellate(const core::Primitive& primitive, const Tessellation& config = {}, Caps caps = {});

}  // namespace sightline::gpuprims
