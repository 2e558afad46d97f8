// The rectangular torus, whole or a slice: tessellation.
#pragma once

#include "sightline/gpuprims/tessellation.h"

namespace sightline::gpuprims {

/// The inner radius is the smaller of the two. From an angle of 2 pi on there are no ends; caps.bottom is the end at
/// angle 0, caps.top the one at `angle`. Without thickness, height or angle it is a surface of two sides.
core::Mesh tessellate(const core::RectangularTorus& torus, const Tessellation& config = {}, Caps caps = {});

}  // namespace sightline::gpuprims
