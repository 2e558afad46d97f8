// Internal: what the kernels of the occluder raster fill. See occluder_raster.h.
#pragma once

namespace sightline::culling {

/// A convex area of a picture, and how near what covers it is. Columns and rows count from the area's own first ones;
/// those of the area lie within the picture.
struct OccluderArea {
  static constexpr int kMostSides = 20, kMostPlanes = 10;

  /// Where a side crosses the middle of a row, in columns to the right of column -1.
  struct Side {
    float x, slope;
  };
  /// Nearness, a linear function of column and row.
  struct Plane {
    float x, y, constant;
  };

  int column, row;  // the first ones; `column` is a multiple of kLanes
  int columns, rows;
  int left_count, right_count, plane_count;
  float least;  // nearness all over the area
  Side left[kMostSides], right[kMostSides];
  Plane planes[kMostPlanes];  // at least one; the least of them counts where it exceeds `least`
};

}  // namespace sightline::culling
