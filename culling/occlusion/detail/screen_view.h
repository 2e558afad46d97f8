// Internal: a view as sample and occlusion tests see it.
#pragma once

#include <array>
#include <cstdint>

#include "sightline/core/view.h"

namespace sightline::culling {

/// x, y, z: coefficients of a point's coordinates, relative to the origin of the bounds; d: the constant term; error:
/// what was lost before d became float.
struct LinearForm {
  float x, y, z, d, error;
};

struct ScreenView {
  LinearForm x, y, w;         // x / w, y / w: place in the image, in pixels, with the first pixel's centre at 0
  LinearForm t;               // distance from the eye along the viewing direction
  float last_x, last_y;       // the last pixel's centre
  const float (*samples)[2];  // offsets from the pixel centre
  int sample_count;
  float snap;     // pixels by which a rasteriser may move a vertex
  float largest;  // coordinates of boxes that are projected: their products with coefficients are finite
  /// A square metre that faces the eye takes |facing[0] + x facing[1] + y facing[2]| / w² pixels at the place x, y.
  float facing[3][3];
};

/// `origin`: of the bounds whose boxes are seen. `snap`: as in ScreenView. The samples are left out.
ScreenView make_screen_view(const core::View& view, const core::dvec3& origin, int width, int height, float snap);

/// A box's minimum, then its maximum.
using BoxCoordinates = std::array<float, 6>;

/// Pixels x0 … x1, y0 … y1.
struct PixelRectangle {
  int x0, y0, x1, y1;
};

/// A DepthPyramid, with the width and the first block of each level.
struct PyramidBlocks {
  static constexpr int kMostLevels = 16;  // entries of both arrays, used or not
  const float* farthest;
  const std::int32_t *widths, *firsts;
  int level_count;
};

/// The rays of an image: at distance t the ray of the pixel (x, y) is at from + t * (constant + x * per_x + y *
/// per_y), or, if parallel, at constant + x * per_x + y * per_y + t * along. Rounded to float.
struct RayField {
  float constant[3], per_x[3], per_y[3], from[3], along[3];
  float constant_rest[3], from_rest[3];  // what rounding took from two of these, if parallel or if not
  float error[3];                        // of the linear function of x and y, with its evaluation in float
  float grown[3];                        // metres by which boxes must grow
  bool parallel;
};

/// constant + x * (place in the image).x + y * (place in the image).y.
struct ImageFunction {
  float constant, x, y;
};

/// The ray of a pixel meets a box where all `far` are at most all `near`, and enters it at the least of `near`: see
/// detail/ray_spans.h.
struct BoxSpan {
  ImageFunction near[3], far[6];
  int near_count, far_count;
};

}  // namespace sightline::culling
