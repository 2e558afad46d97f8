// The box: reference intersection and tessellation.
#pragma once

#include "sightline/gpuprims/internal/tessellation.h"

namespace sightline::gpuprims {

/// Crossings of the ray's full line with the surface, in rising t: 0 or 2, the box is convex. Of size 0 along an axis
/// it is a surface of two sides at one t (the side facing the ray first), and nothing edge on; of size 0 along two it
/// is a line, which shows nothing. Caps are ignored: a box has no ends.
///
/// Slabs: Kay and Kajiya, "Ray Tracing Complex Scenes", SIGGRAPH 1986.
template <class Real = double>
Hits intersect(const core::Box& box, const Ray& ray, Caps caps = {});

/// Twelve triangles whatever the tolerance. A box without caps is still whole: it has no ends.
core::Mesh tessellate(const core::Box& box, const Tessellation& config = {}, Caps caps = {});

}  // namespace sightline::gpuprims
