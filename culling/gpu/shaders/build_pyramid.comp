// One level of a pyramid of farthest distances: culling::DepthPyramid. The first level is of single pixels. A block of
// another level holds 2 x 2 blocks of the one before, at the right and upper edge fewer.
#include "cull_limits.glsl"

layout(local_size_x = kPyramidGroup, local_size_y = kPyramidGroup) in;

layout(std430, binding = 0) restrict buffer Farthest {
  float farthest[];  // of all levels
};
layout(location = 0) uniform uvec3 level;  // first texel, width, height

#ifdef PIXELS
layout(binding = 0) uniform sampler2D depths;     // reverse-Z
layout(location = 1) uniform dvec4 eye_from_depth;  // a, b, c, d: the distance is (a - b depth) / (c - d depth)

const float kNothing = 3.4028235e38;  // no distance is larger, and none of a box is as large

float farthest_of(uvec2 block) {
  float depth = texelFetch(depths, ivec2(block), 0).x;
  double distance = (eye_from_depth.x - eye_from_depth.y * depth) / (eye_from_depth.z - eye_from_depth.w * depth);
  return depth > 0.0 && distance < kNothing ? float(distance) : kNothing;
}
#else
layout(location = 1) uniform uvec3 finer;

float farthest_of(uvec2 block) {
  uvec2 low = 2u * block, high = min(low + 1u, finer.yz - 1u);
  uvec2 rows = finer.x + finer.y * uvec2(low.y, high.y);
  return max(max(farthest[rows.x + low.x], farthest[rows.x + high.x]),
             max(farthest[rows.y + low.x], farthest[rows.y + high.x]));
}
#endif

void main() {
  uvec2 block = gl_GlobalInvocationID.xy;
  if (block.x < level.y && block.y < level.z) farthest[level.x + block.y * level.y + block.x] = farthest_of(block);
}
