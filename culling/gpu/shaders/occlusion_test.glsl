// Which boxes are hidden behind what is already drawn: culling/occlusion/occlusion_test.h, with the rectangles of screen_box.glsl.

#include "screen_box.glsl"

layout(std140, binding = 3) uniform OcclusionBlock {
  uvec4 levels[kMaxLevels];  // of the pyramid, from single pixels on: first texel, width
  int level_count;
  float error;      // what the depth image may have lost of a distance, metres
  uint this_frame;  // counts frames from 2 on
} occlusion;

layout(binding = 5) uniform samplerBuffer farthest;  // distances, see build_pyramid.comp

layout(std430, binding = 5) restrict buffer UnoccludedFrames {
  uint unoccluded_frames[];  // by record or part: the last frame in which it was not hidden, or 0
};

const float kDistanceMargin = 1.0 / 65536.0;  // OcclusionTest::kDistanceMargin

// True only if the pixels first ... last hold less than `distance`: DepthPyramid::all_nearer().
bool all_nearer(ivec2 first, ivec2 last, float distance) {
  ivec2 span = last - first;
  int level = clamp(findMSB(max(span.x, span.y)) - 2, 0, occlusion.level_count - 1);
  uvec4 blocks = occlusion.levels[level];
  first >>= level;
  last >>= level;
  for (int y = first.y; y <= last.y; ++y)
    for (int x = first.x; x <= last.x; ++x)
      if (!(texelFetch(farthest, int(blocks.x) + y * int(blocks.y) + x).x < distance)) return false;
  return true;
}

// Also true of boxes that cover no sample. For images with one sample per pixel, at its centre.
bool occluded(ScreenBox box) {
  if (!box.projects) return false;
  if (!covers_sample(box)) return true;
  ivec2 first = ivec2(ceil(max(box.low, vec2(0.0)))), last = ivec2(min(box.high, screen.last));
  return all_nearer(first, last, box.nearest - (kDistanceMargin * abs(box.nearest) + occlusion.error));
}

bool unoccluded_in_frame_before(uint record) {
  return unoccluded_frames[record] == occlusion.this_frame - 1u;
}
