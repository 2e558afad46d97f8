// The box: reference intersection and tessellation.
#pragma once

#include "sightline/gpuprims/internal/tessellation.h"

namespace sightline::gpuprims {

/// Crossings of the ray's full line with the surface, in rising t: 0 or 2, since the box is convex. With size 0 along
/// one axis it is a two-sided surface with both crossings at one t (the side facing the ray first), and nothing edge
/// on. With size 0 along two axes it is a line, which shows nothing. Caps are ignored: a box has no ends.
///
/// Slabs: Kay and Kajiya, "Ray Tracing Complex Scenes", SIGGRAPH 1986.
Hits intersect(const core::Box& box, const Ray& ray, Caps caps = {});

/// Twelve triangles whatever the tolerance. Caps are ignored: a box has no ends.
core::Mesh tessellate(const core::Box& box, const Tessellation& config = {}, Caps caps = {});

}  // namespace sightline::gpuprims
