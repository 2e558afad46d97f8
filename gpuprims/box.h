// The box: tessellation.
#pragma once

#include "sightline/gpuprims/tessellation.h"

namespace sightline::gpuprims {

/// Twelve triangles whatever the tolerance. A box without caps is still whole: it has no ends.
core::Mesh tessellate(const core::Box& box, const Tessellation& config = {}, Caps caps = {});

}  // namespace sightline::gpuprims
