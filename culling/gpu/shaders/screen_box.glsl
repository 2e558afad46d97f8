// Which samples of an image a box may cover, and how near it may be: culling/occlusion/internal/screen_boxes.h, which argues why
// the rectangle contains the projection. GLSL leaves more open than C++: sums and products may be off by 2^-23 of their
// size, twice as much, quotients by 2.5 units in the last place, and denormals may be zero. The bands, which the C++
// side computes (culling/gpu/gpu_screen.cpp), and kQuotientError hold all that. `precise` keeps operations in order.

#include "cull_limits.glsl"

layout(std140, binding = 2) uniform ScreenBlock {
  // Four linear forms of a point p: X, Y, W with X / W and Y / W its place in the image in pixels, the first pixel's
  // centre at 0; and its distance from the eye. A value is (along_x p.x + along_y p.y) + (along_z p.z + constant).
  vec4 along_x, along_y, along_z, constant;
  // Their errors are less than band_x |p.x| + band_y |p.y| + band_z |p.z| + band_constant.
  vec4 band_x, band_y, band_z, band_constant;
  vec2 last;      // the last pixel's centre
  float largest;  // coordinates of boxes that are projected
  int sample_count;
  float snap;  // what a rasteriser may move a vertex by, pixels
  vec4 samples[kMaxSamples];  // xy: offset from the pixel's centre
} screen;

const float kQuotientError = 1e-6;  // 1 / w, then a product: 7 units of 2^-24; and what follows
const float kFarOutside = 1e30;     // pixels; what is farther is not computed with

struct ScreenBox {
  vec2 low, high;  // rectangle, pixels
  float nearest;   // distance
  bool projects;   // otherwise the rest means nothing, and the box may cover everything
};

ScreenBox project_box(vec3 low, vec3 high) {
  precise vec4 x[2] = vec4[2](screen.along_x * low.x, screen.along_x * high.x);
  precise vec4 y[2] = vec4[2](screen.along_y * low.y, screen.along_y * high.y);
  precise vec4 z[2] = vec4[2](screen.along_z * low.z + screen.constant, screen.along_z * high.z + screen.constant);
  vec2 least = vec2(0.0), most = vec2(0.0);
  vec2 least_wt = vec2(0.0);
  for (int corner = 0; corner < 8; ++corner) {
    precise vec4 value = (x[corner & 1] + y[(corner >> 1) & 1]) + z[corner >> 2];
    precise vec2 place = value.xy * (1.0 / value.z);
    least = corner == 0 ? place : min(least, place);
    most = corner == 0 ? place : max(most, place);
    least_wt = corner == 0 ? value.zw : min(least_wt, value.zw);
  }
  vec3 size = max(abs(low), abs(high));
  precise vec4 band =
      (screen.band_x * size.x + screen.band_y * size.y) + (screen.band_z * size.z + screen.band_constant);
  precise vec2 farthest = max(abs(least), abs(most));
  precise vec2 of_forms = (band.xy + farthest * band.z) * (1.01 / (least_wt.x - band.z));
  precise vec2 half_extent = (of_forms + kQuotientError * farthest) + screen.snap;
  ScreenBox box;
  box.low = least - half_extent;
  box.high = most + half_extent;
  box.nearest = least_wt.y - band.w;
  // Each comparison is false of a NaN.
  box.projects = all(lessThanEqual(low, high)) && all(lessThan(size, vec3(screen.largest))) &&
                 4.0 * band.z < least_wt.x && all(lessThan(farthest + half_extent, vec2(kFarOutside)));
  return box;
}

// Whether no sample lies between two limits: neither 0 + offset nor 1 + offset nor ... last + offset.
bool between_samples(float low, float high, float offset, float last) {
  precise float from = max(low - offset, 0.0), to = max(min(high - offset, last), -1.0);
  return to < from || floor(to) < from;
}

// Whether a box may cover a sample of the image.
bool covers_sample(ScreenBox box) {
  if (!box.projects) return true;
  for (int i = 0; i < screen.sample_count; ++i) {
    vec2 offset = screen.samples[i].xy;
    if (!between_samples(box.low.x, box.high.x, offset.x, screen.last.x) &&
        !between_samples(box.low.y, box.high.y, offset.y, screen.last.y))
      return true;
  }
  return false;
}
