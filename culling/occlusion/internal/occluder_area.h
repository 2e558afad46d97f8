// Internal: what the kernels of the occluder raster fill. See occluder_raster.h.
#pragma once

namespace sightline::culling {

namespace raster {

// Bound for the rounding of a form's value, by the sum of its terms' sizes; more than twice what it can be.
inline constexpr double kLost = 0x1p-48;
// The bound of what is computed from places in the image.
inline constexpr double kPlaceLost = 0x1p-44;
// The raster leaves out occluders whose corners may be off by more, in pixels.
inline constexpr double kMostError = 0x1p-7;
// Numbers beyond are left out, so that no float over- or underflows.
inline constexpr double kLarge = 1e30;
inline constexpr double kSteepest = 0x1p20;  // slopes of sides; others are level

}  // namespace raster

inline constexpr int kPolygonsAtOnce = 8;

/// Convex polygons, an entry of each array for each. Coordinates are relative to the eye, with the axes of the world.
/// Four corners need not be in one plane.
template <int kCorners>
struct PolygonBatch {
  alignas(64) double x[kCorners][kPolygonsAtOnce], y[kCorners][kPolygonsAtOnce], z[kCorners][kPolygonsAtOnce];
  alignas(64) double magnitudes[3][kPolygonsAtOnce];  // at least the magnitudes of coordinates, axis by axis
  int count;                                          // entries behind are any numbers
};

/// A convex area of an image, and how near what covers it is. Columns and rows count from the area's own first ones;
/// those of the area lie within the image.
struct OccluderArea {
  static constexpr int kMostSides = 20, kMostPlanes = 10;

  /// Where a side crosses the middle of a row, in columns to the right of column -1.
  struct Side {
    float x, slope;
  };
  /// Reciprocal depth, a linear function of column and row.
  struct Plane {
    float x, y, constant;
  };

  int column, row;  // the first ones; `column` is a multiple of kLanes
  int columns, rows;
  int left_count, right_count, plane_count;
  float least;  // reciprocal depth all over the area
  Side left[kMostSides], right[kMostSides];
  Plane planes[kMostPlanes];  // at least one; the least of them counts where it exceeds `least`
};

}  // namespace sightline::culling
