// Internal: a view as sample and occlusion tests see it.
#pragma once

namespace sightline::culling {

/// x, y, z: coefficients of a point's coordinates, relative to the origin of the bounds; d: the constant term; error:
/// what was lost before d became float.
struct LinearForm {
  float x, y, z, d, error;
};

struct ScreenView {
  /// Pixels by which a rasteriser may move a vertex: GL requires only four bits of sub-pixel precision.
  static constexpr float kSnap = 0.08f;

  LinearForm x, y, w;         // x / w, y / w: place in the picture, in pixels, with the first pixel's centre at 0
  LinearForm t;               // distance from the eye along the viewing direction
  float last_x, last_y;       // the last pixel's centre
  const float (*samples)[2];  // offsets from the pixel centre
  int sample_count;
  float largest;  // coordinates of boxes that are projected: their products with coefficients are finite
};

}  // namespace sightline::culling
