// measure: what can be measured on an item, in double precision and from the parameters of the analytic primitives
// themselves, not from triangles. Features and dimensions, snapping, distances and angles.
//
// World coordinates are metres. Placements may scale, shear and mirror, and they may be singular.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "sightline/core/api.h"
#include "sightline/core/error.h"
#include "sightline/core/primitive.h"

namespace sightline::measure {

using core::dvec3;

struct Segment {
  dvec3 from, to;
};
/// Infinite in both directions. The direction need not have unit length; a zero direction leaves one point.
struct Line {
  dvec3 through, direction;
};
/// centre + cos(t) u + sin(t) v, from <= t <= to, in radians. u and v are perpendicular: the half-axes of an ellipse,
/// or two radii of a circle. Either may be zero.
struct Arc {
  dvec3 centre, u, v;
  double from = 0.0, to = core::kFullTurn;
};
/// A bounded plane face: the convex polygon of `corners`, or, where there are none, all centre + s (cos(t) u + sin(t)
/// v), inner <= s <= 1, from <= t <= to. So a disc has inner = 0 and a full turn.
struct Face {
  dvec3 centre;
  dvec3 normal;  ///< unit, outwards; zero where the face is degenerate
  std::vector<dvec3> corners;
  dvec3 u{0.0}, v{0.0};
  double inner = 0.0, from = 0.0, to = core::kFullTurn;
};
/// A dvec3 is a point.
using Geometry = std::variant<dvec3, Segment, Line, Arc, Face>;

/// In the order in which snapping prefers them.
enum class FeatureKind : std::uint8_t {
  kCorner,  ///< point
  kEdge,    ///< segment, or arc: the rim of a round end
  kCentre,  ///< point: of a circle, an ellipse, a bend or a sphere
  kAxis,    ///< segment, or arc: the centre line of a torus
  kFace,
  kSurface,  ///< point: of a curved face, or of the cap that a section plane leaves; as good as a face
};

struct Feature {
  FeatureKind kind;
  core::Kind of;          ///< the item's kind
  std::string_view part;  ///< where on the item: "the lower end", "a cylindrical face", or empty; a literal
  Geometry geometry;
};

/// "centre of the lower end of a cylinder".
SIGHTLINE_API std::string describe(const Feature& feature);

/// All features of a primitive, in world coordinates and exact up to double rounding. Ends are called lower and upper
/// by their centres' z. Degenerate primitives have degenerate features. Rims of snouts whose slanted ends have no
/// closed contour (core::EndRange::limited) or cross each other are left out. Fails when a parameter or the placement
/// is not finite.
SIGHTLINE_API core::Expected<std::vector<Feature>> features(const core::Primitive& primitive,
                                                            const core::Affine& world_from_item);

/// A length or angle that an item has by its parameters.
struct Dimension {
  std::string_view name;  ///< "diameter", "bend radius"; a literal
  double value;           ///< metres, or radians where `angle`
  bool angle = false;
};

/// Diameters, radii, lengths and angles of a primitive under its placement. Where a shear or an unequal scale makes a
/// circle an ellipse, its "largest diameter" and "smallest diameter" are given. The diameter of a cylinder is that of
/// its section perpendicular to the axis. The bend radius and the sweep of a torus are left out where its centre line
/// is an ellipse. Fails as features() does.
SIGHTLINE_API core::Expected<std::vector<Dimension>> dimensions(const core::Primitive& primitive,
                                                                const core::Affine& world_from_item);

/// Half-axes of the ellipse centre + cos(t) u + sin(t) v of any u and v, as an arc over the same points.
SIGHTLINE_API Arc principal_axes(const Arc& arc);

}  // namespace sightline::measure
