// The analytic primitives: reference intersection and tessellation of each kind, and of any. The sources of a kind
// share one stem, by its name.
#pragma once

#include "sightline/gpuprims/internal/tessellation.h"

namespace sightline::gpuprims {

/// Crossings of the ray's full line with any primitive, in rising t, as said below of each kind. A line has none.
/// Rays and parameters that are not finite give no hits.
Hits intersect(const core::Primitive& primitive, const Ray& ray, Caps caps = {});

/// Triangles of any primitive, as tessellation.h promises. A line has none. Kinds without ends ignore caps.
core::Mesh tessellate(const core::Primitive& primitive, const Tessellation& config = {}, Caps caps = {});

// The box.

/// Crossings of the ray's full line with the surface, in rising t: 0 or 2, since the box is convex. With size 0 along
/// one axis it is a two-sided surface with both crossings at one t (the side facing the ray first), and nothing edge
/// on. With size 0 along two axes it is a line, which shows nothing. Caps are ignored: a box has no ends.
///
/// Slabs: Kay and Kajiya, "Ray Tracing Complex Scenes", SIGGRAPH 1986.
Hits intersect(const core::Box& box, const Ray& ray, Caps caps = {});

/// Twelve triangles whatever the tolerance. Caps are ignored: a box has no ends.
core::Mesh tessellate(const core::Box& box, const Tessellation& config = {}, Caps caps = {});

// The frustum of a pyramid.

/// Crossings of the ray's full line with the surface, in rising t: 0 or 2, since the solid is convex. An end may be a
/// line or a point. If both ends have no width in x, or none in y, the solid is a two-sided surface with both crossings
/// at one t, and nothing edge on. The same holds for height 0: then it is the hull of both ends at z = 0, as its bounds
/// have it. Without width in x and y it is nothing.
///
/// Half-spaces: both ends, and |x - c(z)| <= w(z) with centre and half width linear in z; likewise in y.
Hits intersect(const core::Pyramid& pyramid, const Ray& ray, Caps caps = {});

/// At most twelve triangles whatever the tolerance; caps.bottom and caps.top are its two rectangles.
core::Mesh tessellate(const core::Pyramid& pyramid, const Tessellation& config = {}, Caps caps = {});

// The cylinder.

/// Crossings of the ray's full line with the surface, in rising t. A closed cylinder has 0 or 2, since it is convex.
/// Height 0 is a two-sided disc with both crossings at one t (the side facing the ray first); radius 0 is nothing. An
/// open end drops its crossing.
///
/// Half-chord form of the quadratic about a point close to the cylinder (see local_ray.h). With o and u the parts of
/// origin and direction across the axis, the crossings lie sqrt(r^2 u.u - (o x u)^2) / u.u to both sides of s = -o.u /
/// u.u.
Hits intersect(const core::Cylinder& cylinder, const Ray& ray, Caps caps = {});

core::Mesh tessellate(const core::Cylinder& cylinder, const Tessellation& config = {}, Caps caps = {});

// The snout.

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

// The sphere.

/// Crossings of the ray's full line with the surface, in rising t: 0 or 2. Diameter 0 is nothing. Caps are ignored.
/// Half-chord form about the point closest to the centre; see dome.h.
Hits intersect(const core::Sphere& sphere, const Ray& ray, Caps caps = {});

/// By latitude and longitude. A sphere has no ends: caps are ignored.
core::Mesh tessellate(const core::Sphere& sphere, const Tessellation& config = {}, Caps caps = {});

// The cap of a sphere.

/// Crossings of the ray's full line with the surface, in rising t: 0 or 2 when closed, since the dish is convex.
/// caps.bottom is the base; there is no top. Height 0 (or below 1e-18 radii) is a two-sided disc with both crossings at
/// one t; without its base it has only the upper one. Base radius 0 is the whole ball above z = 0, and both 0 are
/// nothing. The quadratic: see dome.h.
Hits intersect(const core::SphericalDish& dish, const Ray& ray, Caps caps = {});

/// Rings at equal angles of the sphere's meridian; caps.bottom is the base, there is no top. With a height above its
/// base radius it is more than half a sphere. Base radius 0 with a height is the whole sphere of that diameter.
core::Mesh tessellate(const core::SphericalDish& dish, const Tessellation& config = {}, Caps caps = {});

// Half an ellipsoid of revolution.

/// Crossings of the ray's full line with the surface, in rising t: 0 or 2 when closed, since the dish is convex.
/// caps.bottom is the base; there is no top. Height 0 (or below 1e-18 radii) is a two-sided disc with both crossings at
/// one t; without its base it has only the upper one. Base radius 0 is nothing. The quadratic: see dome.h.
Hits intersect(const core::EllipticalDish& dish, const Ray& ray, Caps caps = {});

/// Rings at equal parameter angles of the ellipse; caps.bottom is the base, there is no top.
core::Mesh tessellate(const core::EllipticalDish& dish, const Tessellation& config = {}, Caps caps = {});

// The circular torus, whole or a slice.

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

// The rectangular torus, whole or a slice.

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
