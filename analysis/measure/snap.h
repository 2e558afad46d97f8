// Snapping: the feature of an item that a user points at.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "sightline/analysis/measure/features.h"
#include "sightline/analysis/measure/item.h"
#include "sightline/core/view.h"

namespace sightline::measure {

/// The ray under the cursor. A feature may lie off it by slope * (distance along the ray) + Aim::radius: the slope of a
/// cone for perspective views, the radius alone for orthographic ones.
struct AimRay {
  dvec3 origin, direction;  ///< the direction has unit length
  double slope = 0.0;       ///< tangent of the cone's half angle
};

/// Where a user points at.
struct Aim {
  dvec3 point;          ///< on the item's surface: what a pick returned
  double radius = 0.0;  ///< metres
  std::optional<AimRay> ray;
};

struct Snap {
  Feature feature;
  dvec3 point;        ///< on the feature, exact up to double rounding; the nearest one to 1e-6 of the reach
  std::string words;  ///< describe(feature)
  /// Sizes of a primitive as measure::dimensions() has them; for a mesh those of the face that the feature belongs to,
  /// where the mesh's file states its surface: STEP, IGES and BREP.
  std::vector<Dimension> dimensions = {};
  std::optional<Segment> axis = {};  ///< the straight axis of what has the dimensions, if it has one
};

/// The feature of the item within reach of the aim that comes first in the order of FeatureKind, and of these the
/// nearest one. Where there is none, the point of the surface itself: each point that a pick returns can be snapped to.
/// None where the aim's point is farther from what is kept of the item than the reach.
///
/// With a ray, corners and edges are those within its cone that the item itself does not hide, at their point nearest
/// to the aim's point. Edges count up to four times the reach away from it: a surface at a grazing angle looks shorter.
/// Centres and axes lie inside the item and count where they pass the ray. Without a ray all count that lie within the
/// radius of the aim's point.
///
/// What the section planes remove does not count: a point there is not snapped to, an edge or axis only where it is
/// kept, and what is removed hides nothing. Points within 1 nm of a plane are kept. Planes with a zero normal are
/// ignored.
///
/// The edges of a mesh are those where its triangles turn by more than 20 degrees, and its corners are where such edges
/// meet. Its faces are triangles, or points of the surface that its file states for a curved face, whose axis and
/// centres count, too, where the face itself is near the aim's point.
SIGHTLINE_API std::optional<Snap> snap(const Item& item, const Aim& aim, std::span<const core::Plane> sections = {},
                                       core::SectionMode mode = core::SectionMode::kIntersection);

}  // namespace sightline::measure
