// The frustum of a pyramid: tessellation.
#pragma once

#include "sightline/gpuprims/tessellation.h"

namespace sightline::gpuprims {

/// At most twelve triangles whatever the tolerance; caps.bottom and caps.top are its two rectangles.
core::Mesh tessellate(const core::Pyramid& pyramid, const Tessellation& config = {}, Caps caps = {});

}  // namespace sightline::gpuprims
