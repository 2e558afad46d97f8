// Half an ellipsoid of revolution: reference intersection and tessellation.
#pragma once

#include "sightline/gpuprims/internal/tessellation.h"

namespace sightline::gpuprims {

/// Crossings of the ray's full line with the surface, in rising t: 0 or 2 when closed, since the dish is convex.
/// caps.bottom is the base; there is no top. Height 0 (or below 1e-18 radii) is a two-sided disc with both crossings at
/// one t; without its base it has only the upper one. Base radius 0 is nothing. The quadratic: see dome.h.
Hits intersect(const core::EllipticalDish& dish, const Ray& ray, Caps caps = {});

/// Rings at equal parameter angles of the ellipse; caps.bottom is the base, there is no top.
core::Mesh tessellate(const core::EllipticalDish& dish, const Tessellation& config = {}, Caps caps = {});

}  // namespace sightline::gpuprims
