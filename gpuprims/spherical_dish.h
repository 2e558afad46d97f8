// The cap of a sphere: tessellation.
#pragma once

#include "sightline/gpuprims/tessellation.h"

namespace sightline::gpuprims {

/// Rings at equal angles of the sphere's meridian; caps.bottom is the base, there is no top. Higher than its base
/// radius it is more than half a sphere; base radius 0 with a height is the whole sphere of that diameter.
core::Mesh tessellate(const core::SphericalDish& dish, const Tessellation& config = {}, Caps caps = {});

}  // namespace sightline::gpuprims
