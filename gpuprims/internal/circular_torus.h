// The circular torus, whole or a slice: reference intersection and tessellation.
#pragma once

#include "sightline/gpuprims/internal/tessellation.h"

namespace sightline::gpuprims {

/// Crossings of the ray's full line with the surface, in rising t: an even number up to 6 when closed. A torus of a
/// full turn (core::sweep_angle) has no ends. caps.bottom is the end at angle 0, caps.top the one at `angle`. Angle 0
/// is a two-sided disc, tube radius 0 is nothing. A horn or spindle torus (major <= tube radius) has no inner wall:
/// only the part of the disc on its own side of the axis sweeps the solid.
///
/// The origin is the line's point closest to the centre (o.u = 0, |u| = 1). With k = |o|^2 + R^2 - r^2, A = u_x^2 +
/// u_y^2 and B = o_x u_x + o_y u_y, the surface is F(s) = (s^2 + k)^2 - 4 R^2 (A s^2 + 2 B s + o_x^2 + o_y^2) = 0. F' =
/// 4 (s^3 + (k - 2 R^2 A) s - 2 R^2 B) is a depressed cubic, solved in closed form. Its roots cut the line into at most
/// four monotone pieces with at most one crossing each. Bracketed Newton on G(s) = (sqrt(x^2 + y^2) - R)^2 + z^2 - r^2
/// finds every crossing. G keeps its precision, while F, a difference of fourth powers, does not. Quartic: Hanrahan, "A
/// Survey of Ray-Surface Intersection Algorithms", in Glassner (ed.), "An Introduction to Ray Tracing" (1989). Roots
/// between the derivative's roots: Hook and McAree, "Using Sturm Sequences to Bracket Real Roots", Graphics Gems
/// (1990), and Yuksel, "High-Performance Polynomial Root Finding for Graphics" (2022). Safeguarded Newton: Press et
/// al., "Numerical Recipes", section 9.4.
Hits intersect(const core::CircularTorus& torus, const Ray& ray, Caps caps = {});

core::Mesh tessellate(const core::CircularTorus& torus, const Tessellation& config = {}, Caps caps = {});

}  // namespace sightline::gpuprims
