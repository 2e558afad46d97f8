// The rectangular torus, whole or a slice: reference intersection and tessellation.
#pragma once

#include "sightline/gpuprims/internal/tessellation.h"

namespace sightline::gpuprims {

/// Crossings of the ray's full line with the surface, in rising t: an even number up to 6 when closed. From an angle of
/// 2 pi on there are no ends; caps.bottom is the end at angle 0, caps.top the one at `angle`. The smaller of the two
/// radii is the inner one. Without thickness, height or angle it is a two-sided surface, where each crossing counts
/// twice at one t, and nothing edge on. Outer radius 0 is nothing.
///
/// The result is the outer cylinder's span between both levels, minus the inner cylinder's span, minus what the sweep
/// leaves out (wedge.h).
Hits intersect(const core::RectangularTorus& torus, const Ray& ray, Caps caps = {});

/// The smaller of the two radii is the inner one. From an angle of 2 pi on there are no ends; caps.bottom is the end at
/// angle 0, caps.top the one at `angle`. Without thickness, height or angle it is a two-sided surface.
core::Mesh tessellate(const core::RectangularTorus& torus, const Tessellation& config = {}, Caps caps = {});

}  // namespace sightline::gpuprims
