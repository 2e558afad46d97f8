// Half an ellipsoid of revolution: tessellation.
#pragma once

#include "sightline/gpuprims/tessellation.h"

namespace sightline::gpuprims {

/// Rings at equal parameter angles of the ellipse; caps.bottom is the base, there is no top.
core::Mesh tessellate(const core::EllipticalDish& dish, const Tessellation& config = {}, Caps caps = {});

}  // namespace sightline::gpuprims
