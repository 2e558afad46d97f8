// The snout: a truncated cone, eccentric and with slanted ends. Reference intersection and tessellation.
#pragma once

#include "sightline/gpuprims/internal/tessellation.h"

namespace sightline::gpuprims {

/// Crossings of the ray's full line with the surface, in rising t. A closed snout is convex and has 0 or 2.
///
/// The solid is one nappe of the sheared cone |xy - c(z)| <= r(z), r(z) >= 0, above the bottom and below the top end
/// plane. c(z) = offset z / height, and r is linear from the bottom to the top radius. Where an end plane has no closed
/// contour on the cone (core::EndRange), a level cut one height beyond that end replaces it. Height 0 is a level
/// two-sided disc about the centre of the larger end (the bottom one if both are equal). Both radii 0 is nothing, and
/// so is a cone of which the plane through its apex leaves the apex alone.
///
/// Along the ray, w = xy - c and r are linear: w0 + s w1, r0 + s r1. The discriminant of |w|^2 - r^2 is computed as |r0
/// w1 - r1 w0|^2 - (w0 x w1)^2: Lagrange's identity, with the large terms cancelled by hand. The roots follow Press et
/// al., "Numerical Recipes", section 5.6. So rays parallel to a generator and equal radii need no special case.
Hits intersect(const core::Snout& snout, const Ray& ray, Caps caps = {});

/// Contour points lie on the true intersection of cone and end plane: at equal angles about the cone's axis, and where
/// the two end planes meet within the cone. An end with a level cut besides its plane is closed and within its bounds.
/// But it is only close to the solid of intersect(), and has the plane's normal throughout.
core::Mesh tessellate(const core::Snout& snout, const Tessellation& config = {}, Caps caps = {});

}  // namespace sightline::gpuprims
