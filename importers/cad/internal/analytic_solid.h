// Internal to the importers: tells solids that are analytic primitives, or unions of some, by their surfaces. Needs no
// Open CASCADE: solid_surfaces.h makes the input.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "sightline/core/affine.h"
#include "sightline/core/primitive.h"

namespace sightline::importers {

enum class SurfaceKind : std::uint8_t { kPlane, kCylinder, kCone, kSphere, kTorus };

/// A closed curve between two patches, in the plane that fits it best.
struct Border {
  std::uint32_t neighbour = 0;  ///< the patch on its other side
  core::dvec3 centre{0.0}, normal{0.0};
  double off_plane = 0.0;  ///< how far it leaves that plane
};

/// All faces of a solid that lie in one surface.
struct SurfacePatch {
  SurfaceKind kind = SurfaceKind::kPlane;
  core::dvec3 origin{0.0}, axis{0.0, 0.0, 1.0};  ///< planes: the normal, outwards; spheres: any
  double radius = 0.0;       ///< tori: of the circle in which the tube's centre runs; cones: at the origin
  double tube_radius = 0.0;  ///< of tori
  double slope = 0.0;        ///< of cones: by how much the radius grows along the axis
  bool convex = true;        ///< the solid lies on the side of the axis, or of the tube's centre
  core::dvec3 inside{0.0};   ///< a point of the patch
  double area = 0.0;
  std::vector<Border> borders;
};

/// A solid with one shell. Lengths have any unit.
struct SolidSurfaces {
  std::vector<SurfacePatch> patches;
  std::vector<core::dvec3> corners;  ///< each once
  double volume = 0.0;
  double tolerance = 0.0;    ///< points nearer than this are one
  double merge_error = 0.0;  ///< how far faces lie from the surface of their patch
};

struct AnalyticPart {
  core::Primitive primitive;
  core::Affine solid_from_primitive;
};
struct AnalyticSolid {
  std::vector<AnalyticPart> parts;
  double deviation = 0.0;  ///< no point of one surface lies farther from the other one, rounding of parameters included
};

/// The primitives whose union has the same surface within the tolerance, or nothing. These solids are known:
/// - boxes, frusta of pyramids, pyramids and wedges,
/// - sectors of rings with a rectangular profile (rectangular torus),
/// - stacks of coaxial cylinders with a coaxial hole, which may change its radius, or without one: tubes, flanges,
/// rings;
/// - cylinders, cones, torus slices, spheres and domes, and all solids that consist of such pieces joined at planar
///   curves: runs of pipe, stepped shafts, plates with pins. Ends of cylinders and cones may be slanted.
///
/// A candidate counts only if the area of each curved patch is that of its piece, and the solid's volume that of all
/// pieces together.
std::optional<AnalyticSolid> analytic_solid(const SolidSurfaces& solid);

}  // namespace sightline::importers
