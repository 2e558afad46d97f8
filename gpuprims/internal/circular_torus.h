// The circular torus, whole or a slice: reference intersection and tessellation.
#pragma once

#include "sightline/gpuprims/internal/tessellation.h"

namespace sightline::gpuprims {

/// Crossings of the ray's full line with the surface, in rising t: an even number up to 6 when closed. A closed
/// torus (core::sweep_angle) has no ends. caps.bottom is the end at angle 0, caps.top the one at `angle`. Angle 0 is a
/// disc of two sides, tube radius 0 is nothing. For horn and spindle tori (major <= tube radius) the solid is what the
/// disc's half away from the axis sweeps: no inner wall.
///
/// About the point closest to the centre (o.u = 0, |u| = 1), with k = |o|^2 + R^2 - r^2, A = u_x^2 + u_y^2 and
/// B = o_x u_x + o_y u_y, the surface is F(s) = (s^2 + k)^2 - 4 R^2 (A s^2 + 2 B s + o_x^2 + o_y^2) = 0, and
/// F' = 4 (s^3 + (k - 2 R^2 A) s - 2 R^2 B): a depressed cubic, solved in closed form, whose roots cut the line into at
/// most four monotone pieces with at most one crossing each. Every crossing is found by bracketed Newton on G(s) =
/// (sqrt(x^2 + y^2) - R)^2 + z^2 - r^2, which keeps its precision where F, a difference of fourth powers, does not.
/// Quartic: Hanrahan, "A Survey of Ray-Surface Intersection Algorithms", in Glassner (ed.), "An Introduction to Ray
/// Tracing" (1989). Roots between the derivative's roots: Hook and McAree, "Using Sturm Sequences to Bracket Real
/// Roots", Graphics Gems (1990), and Yuksel, "High-Performance Polynomial Root Finding for Graphics" (2022).
/// Safeguarded Newton: Press et al., "Numerical Recipes", section 9.4.
template <class Real = double>
Hits intersect(const core::CircularTorus& torus, const Ray& ray, Caps caps = {});

core::Mesh tessellate(const core::CircularTorus& torus, const Tessellation& config = {}, Caps caps = {});

}  // namespace sightline::gpuprims
