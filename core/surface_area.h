// Areas of surfaces, in square units of the primitive or mesh itself.
#pragma once

#include "sightline/core/api.h"
#include "sightline/core/mesh.h"
#include "sightline/core/primitive.h"

namespace sightline::core {

/// The whole surface, ends included; 0 for lines. Slanted ends of snouts count as straight. That of an eccentric snout
/// is the surface of a straight one as long as its axis, that of an elliptical dish by K. Thomsen's formula, off by 1.1
/// % at most.
SIGHTLINE_API double surface_area(const Primitive& primitive);
/// The sum over all triangles. The mesh must be valid (validate()).
SIGHTLINE_API double surface_area(const Mesh& mesh);

}  // namespace sightline::core
