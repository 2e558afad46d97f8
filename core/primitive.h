// The analytic primitives of plant models: their parameters and their exact extents.
//
// Parameters follow AVEVA's review model (RVM) so that a file can be written back bit for bit: single precision, in the
// primitive's own local units (an item's placement scales them to metres), angles in radians, centred in z unless
// noted. Negative lengths count as their absolute value. A primitive without volume (a cylinder of height 0, a sphere
// of diameter 0) is degenerate, not an error: it stays an item and shows what such a solid shows.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <span>
#include <string_view>
#include <variant>

#include "sightline/core/aabb.h"
#include "sightline/core/affine.h"
#include "sightline/core/api.h"

namespace sightline::core {

/// What an item is. The first ten are the alternatives of Primitive, in the same order; the last two are meshes.
/// Value + 1 is the RVM kind number for all but kMesh.
enum class Kind : std::uint8_t {
  kPyramid,
  kBox,
  kRectangularTorus,
  kCircularTorus,
  kEllipticalDish,
  kSphericalDish,
  kSnout,
  kCylinder,
  kSphere,
  kLine,
  kFacetGroup,
  kMesh,
};
inline constexpr int kPrimitiveKindCount = 10;
inline constexpr int kKindCount = 12;

/// "cylinder", "circular_torus", …: the names used in every file and message.
SIGHTLINE_API std::string_view name_of(Kind kind);

namespace faces {
/// Faces of items. A flat item, such as a cylinder of height 0, has those that are left of it. They convert to numbers,
/// which intersectors and shaders compute with; their names are Face::kSide and so on.
enum Face : std::uint8_t {
  kSide,         ///< round or conical: of cylinders and snouts, spheres, domes of dishes, tubes, outer walls of tori
  kBottom,       ///< at z = -height / 2; the base of a dish; the end of a torus at angle 0
  kTop,          ///< at z = height / 2; the other end of a torus
  kBottomLevel,  ///< of a snout: the level cut in place of an end plane that does not close it
  kTopLevel,
  kInner,  ///< of a rectangular torus: its inner wall, its level sides
  kBelow,
  kAbove,
  kMinX,  ///< the four sides of a box or pyramid
  kMaxX,
  kMinY,
  kMaxY,
  kTriangle,  ///< of a mesh
  kCut,       ///< where a section plane cuts the item open
};
/// "side", "bottom", "min_x", …
SIGHTLINE_API std::string_view name_of(Face face);
}  // namespace faces
using faces::Face;
using faces::name_of;

/// Frustum of a rectangular pyramid. The bottom lies at z = -height/2 around -offset/2, the top at +height/2 around
/// +offset/2.
struct Pyramid {
  float bottom_x, bottom_y, top_x, top_y, offset_x, offset_y, height;
};
struct Box {
  float size_x, size_y, size_z;
};
/// Rectangle (inner..outer radius, height) swept about z by sweep_angle(angle) from +X towards +Y.
struct RectangularTorus {
  float inner_radius, outer_radius, height, angle;
};
/// Disc of radius tube_radius, its centre at major_radius from z, swept about z by sweep_angle(angle) from +X towards
/// +Y.
struct CircularTorus {
  float major_radius, tube_radius, angle;
};
/// A length as it counts: without its sign.
inline double length_of(float parameter) {
  return std::abs(double(parameter));
}
/// The sweep of a torus in radians, 0 … kFullTurn, from its parameter `angle`. Some files write a full turn as a float
/// a little below 2 pi. From there on the sweep is kFullTurn and the torus is closed: it has no ends. NaN stays NaN.
inline constexpr double kFullTurn = 2.0 * std::numbers::pi;
SIGHTLINE_API double sweep_angle(float angle);

/// Half an ellipsoid of revolution: base circle at z = 0, pole at z = height.
struct EllipticalDish {
  float base_radius, height;
};
/// Cap of a sphere: base circle at z = 0, pole at z = height, sphere radius (r^2 + h^2) / 2h.
struct SphericalDish {
  float base_radius, height;
};
/// Truncated cone, eccentric and with slanted ends. End centres lie at -offset/2, z = -height/2 and +offset/2, z =
/// +height/2; with (x, y) relative to the end's centre, the end plane is z = -/+ height/2 + tan(shear_x) x +
/// tan(shear_y) y. The lateral surface is the (sheared) cone through the two unslanted end circles, cut by the end
/// planes.
struct Snout {
  float bottom_radius, top_radius, height, offset_x, offset_y;
  float bottom_shear_x, bottom_shear_y, top_shear_x, top_shear_y;
};
struct Cylinder {
  float radius, height;
};
struct Sphere {
  float diameter;
};
/// Segment on the local x axis.
struct Line {
  float from, to;
};

using Primitive = std::variant<Pyramid, Box, RectangularTorus, CircularTorus, EllipticalDish, SphericalDish, Snout,
                               Cylinder, Sphere, Line>;

inline Kind kind_of(const Primitive& primitive) {
  return static_cast<Kind>(primitive.index());
}

/// Number of float parameters of a primitive kind (1 to 9).
SIGHTLINE_API int parameter_count(Kind kind);

/// The parameters as floats in declaration order: a view into `primitive`.
SIGHTLINE_API std::span<const float> parameters(const Primitive& primitive);

/// The inverse: `kind` must be a primitive kind and `values` hold parameter_count(kind) floats.
SIGHTLINE_API Primitive make_primitive(Kind kind, std::span<const float> values);

/// True when the primitive has no volume (or, for a line, no length).
SIGHTLINE_API bool is_degenerate(const Primitive& primitive);

/// Support function: the largest dot(direction, p) over all points p of the primitive, in local units. Exact up to
/// double rounding for all kinds but the snout with slanted ends, where it is an upper bound.
SIGHTLINE_API double support(const Primitive& primitive, const dvec3& direction);

/// Bounds of the primitive under an affine map, from the support function along the three axes: tight, not box-of-box.
/// A relative pad of a few double ulps covers its rounding. Not finite where a parameter is not.
SIGHTLINE_API AabbD bounds(const Primitive& primitive, const Affine& world_from_item);

/// Range of heights of the cone's surface above (below) an end's centre, over the slanted end contour of a snout. With
/// the end's radius r, tangents m = (tan shear_x, tan shear_y), axis lean s = offset/height and radius slope k, these
/// are the extremes of (r m.e) / (1 - m.s - k m.e) over unit e. Where the plane is steeper than the cone or nearly so,
/// there is no closed contour: the range is limited to one snout height beyond the end. At height 0 it is the slant
/// alone, r m.e.
struct EndRange {
  double min = 0.0, max = 0.0;
  bool limited = false;
};
SIGHTLINE_API EndRange bottom_end_range(const Snout& snout);
SIGHTLINE_API EndRange top_end_range(const Snout& snout);

}  // namespace sightline::core
