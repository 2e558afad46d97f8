// The snout: a truncated cone, eccentric and with slanted ends. Reference intersection and tessellation.
#pragma once

#include "sightline/gpuprims/internal/tessellation.h"

namespace sightline::gpuprims {

/// Crossings of the ray's full line with the surface, in rising t. A closed snout is convex and has 0 or 2.
///
/// The solid: one nappe of the sheared cone |xy - c(z)| <= r(z), r(z) >= 0, with c(z) = offset z / height and r linear
/// from the bottom to the top radius, above the bottom and below the top end plane. Where an end plane has no closed
/// contour on the cone (core::EndRange), that end is cut level one height beyond it instead. Height 0
/// is a disc of two sides, level, about the centre of the larger end (the bottom one where both are equal). Both radii
/// 0 is nothing.
///
/// Along the ray, w = xy - c and r are linear: w0 + s w1, r0 + s r1. The discriminant of |w|^2 - r^2 is taken as
/// |r0 w1 - r1 w0|^2 - (w0 x w1)^2 (Lagrange's identity: the large terms cancelled by hand), the roots by Press et al.,
/// "Numerical Recipes", section 5.6, so that rays parallel to a generator and equal radii need no case of their own.
template <class Real = double>
Hits intersect(const core::Snout& snout, const Ray& ray, Caps caps = {});

/// Contour points lie on the true intersection of cone and end plane, at equal angles about the cone's axis, and where
/// the two end planes meet within the cone. An end that is cut level besides its plane is closed and in its bounds, but
/// no more than close to the intersection's solid, and has the plane's normal throughout.
core::Mesh tessellate(const core::Snout& snout, const Tessellation& config = {}, Caps caps = {});

}  // namespace sightline::gpuprims
