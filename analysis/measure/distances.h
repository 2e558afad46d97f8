// Distances and angles between features and between items.
#pragma once

#include <optional>

#include "sightline/analysis/measure/features.h"
#include "sightline/analysis/measure/item.h"

namespace sightline::measure {

struct Distance {
  double distance = 0.0;  ///< metres; 0 where they touch or intersect
  dvec3 from, to;         ///< the closest points, in the world. One pair of them, where there are several
  /// The true distance is not larger than `distance`, and smaller by at most this, besides rounding of the positions
  /// (about 1e-15 of their distance from the world's origin).
  double error = 0.0;
  bool touching = false;

  /// Difference of elevation.
  double rise() const { return to.z - from.z; }
};

/// Shortest distance of two features. Faces count within their outlines. Coordinates must be finite.
SIGHTLINE_API Distance distance(const Geometry& a, const Geometry& b);

/// Shortest distance of two items, as solids: one within the other touches it. A mesh is a solid where it is closed
/// (core::enclosure()), otherwise a surface.
///
/// Primitives are exact, not tessellated: `error` is at most 1e-9 of the distance plus 1e-10 of the items' size. Two
/// exceptions say so by a larger `error`: slices of a torus that are all equally near, for example to a sphere on its
/// axis (up to 1e-6 of its radius), and snouts whose slanted ends are open or cross each other (about 4e-5 of their
/// size).
///
/// Infinite, with an infinite error, when a mesh has no triangles.
SIGHTLINE_API Distance distance(const Item& a, const Item& b);

/// The distance of a feature to an item.
SIGHTLINE_API Distance distance(const Geometry& feature, const Item& item);

/// The angle between two features in radians, 0 to pi / 2: of two directions, of two planes, or of a direction and a
/// plane. Segments and lines have a direction, arcs and faces a plane. None where one has neither, or is degenerate.
SIGHTLINE_API std::optional<double> angle(const Geometry& a, const Geometry& b);

struct AxisDistance {
  Distance shortest;  ///< of the infinite lines; if parallel, from the middle of where both axes run side by side
  double angle;       ///< radians, 0 to pi / 2
  bool parallel;      ///< angle <= 1e-6: what the single-precision placements of plant models leave of parallel axes
};

/// The distance of two centre lines.
SIGHTLINE_API AxisDistance axis_distance(const Segment& a, const Segment& b);

}  // namespace sightline::measure
