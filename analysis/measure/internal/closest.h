// Closest points of two shapes. Internal to measure.
#pragma once

#include <limits>

#include "sightline/analysis/measure/distances.h"
#include "sightline/analysis/measure/internal/shape.h"

namespace sightline::measure {

/// Bounds of a distance. The points are at the distance `upper` and relative to the common origin.
struct Gap {
  double lower = 0.0, upper = 0.0;
  dvec3 a{0.0}, b{0.0};
  dvec2 slice_a{1, 0}, slice_b{1, 0};  ///< where they lie, in pieces of a sweep
  dvec3 from_b{1, 0, 0};               ///< a - b, or any direction where that is zero
};

/// Between the convex hulls of two pieces, by the GJK algorithm (E. G. Gilbert, D. W. Johnson, S. S. Keerthi, "A fast
/// procedure for computing the distance between complex objects in three-dimensional space", 1988) with signed volumes
/// (M. Montanari, N. Petrinic, E. Barbieri, "Improving the GJK algorithm for faster and more reliable distance queries
/// between convex objects", 2017). `start`: a guess of the vector from b to a; not zero.
Gap convex_gap(const Piece& a, const Piece& b, const dvec3& start);

/// To what closest() is exact: 1e-10 of the radius of the larger sweep, 0 where there is none.
double sweep_tolerance(const Shape& a, const Shape& b);

/// What a search may leave out.
struct SearchLimits {
  double farthest = std::numeric_limits<double>::infinity();  ///< distances beyond need not be exact
  double tolerance = 0.0;                                     ///< metres, where that is more than sweep_tolerance()
};

/// Between two shapes. The points are relative to a's origin. Subdivides sweeps and meshes, the nearest pair of pieces
/// first. A pair whose lower bound exceeds the least upper bound so far cannot matter, so the search cannot miss the
/// minimum. Where very many slices are equally near, it stops early and leaves a larger difference of the bounds. Both
/// bounds are infinite if a shape has no point.
Gap closest(const Shape& a, const Shape& b, const SearchLimits& limits = {});

/// distance() of two features within limits.
Distance limited_distance(const Geometry& a, const Geometry& b, const SearchLimits& limits);

/// Whether a point, relative to the shape's origin, lies within the triangles of a solid mesh, which has some.
bool encloses(const Shape& mesh, const dvec3& point);

}  // namespace sightline::measure
