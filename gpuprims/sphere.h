// The sphere: tessellation.
#pragma once

#include "sightline/gpuprims/tessellation.h"

namespace sightline::gpuprims {

/// By latitude and longitude. A sphere has no ends: caps are ignored.
core::Mesh tessellate(const core::Sphere& sphere, const Tessellation& config = {}, Caps caps = {});

}  // namespace sightline::gpuprims
