// The frustum of a pyramid: reference intersection and tessellation.
#pragma once

#include "sightline/gpuprims/internal/tessellation.h"

namespace sightline::gpuprims {

/// Crossings of the ray's full line with the surface, in rising t: 0 or 2, since the solid is convex. An end may be a
/// line or a point. If both ends have no width in x, or none in y, the solid is a two-sided surface with both crossings
/// at one t, and nothing edge on. The same holds for height 0: then it is the hull of both ends at z = 0, as its bounds
/// have it. Without width in x and y it is nothing.
///
/// Half-spaces: both ends, and |x - c(z)| <= w(z) with centre and half width linear in z; likewise in y.
Hits intersect(const core::Pyramid& pyramid, const Ray& ray, Caps caps = {});

/// At most twelve triangles whatever the tolerance; caps.bottom and caps.top are its two rectangles.
core::Mesh tessellate(const core::Pyramid& pyramid, const Tessellation& config = {}, Caps caps = {});

}  // namespace sightline::gpuprims
