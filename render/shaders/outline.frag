// A line around what a layer shows of some items: full where the image shows them, fainter where something hides them.
#include "srgb.glsl"

#ifdef SAMPLES
layout(binding = 0) uniform sampler2DMS items;
layout(binding = 1) uniform sampler2DMS item_depths;
layout(binding = 2) uniform sampler2DMS depths;
#define COUNT SAMPLES
#define ITEMS_SIZE textureSize(items)
#else
layout(binding = 0) uniform sampler2D items;
layout(binding = 1) uniform sampler2D item_depths;
layout(binding = 2) uniform sampler2D depths;
#define COUNT 1
#define ITEMS_SIZE textureSize(items, 0)
#endif
layout(location = 0) uniform ivec2 corner;  // of the image in the framebuffer, pixels
layout(location = 2) uniform int linear_colour;
layout(location = 3) uniform vec3 line_colour;

layout(location = 0) out vec4 pixel;  // multiplied by its alpha

const int kReach = 2;            // pixels
const float kOccludedLine = 0.35;  // alpha
const float kSameDepth = 1e-4;   // of the depth

// Shares of a pixel's samples that the items cover, and where nothing hides them.
vec2 covered(ivec2 place) {
  vec2 found = vec2(0.0);
  for (int i = 0; i < COUNT; ++i) {
    if (texelFetch(items, place, i).a == 0.0) continue;
    float depth = texelFetch(item_depths, place, i).r;
    bool open = depth >= texelFetch(depths, place, i).r * (1.0 - kSameDepth);
    found += vec2(1.0, float(open)) / float(COUNT);
  }
  return found;
}

void main() {
  ivec2 place = ivec2(gl_FragCoord.xy) - corner, size = ITEMS_SIZE;
  vec2 here = covered(place), around = vec2(0.0);
  if (here.x >= 1.0) discard;
  for (int y = -kReach; y <= kReach; ++y) {
    for (int x = -kReach; x <= kReach; ++x) {
      ivec2 at = place + ivec2(x, y);
      if (x * x + y * y > kReach * kReach + 1 || any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, size))) continue;
      around = max(around, covered(at));
    }
  }
  float alpha = max(around.y, kOccludedLine * around.x) * (1.0 - here.x);
  if (alpha == 0.0) discard;
  pixel = vec4((linear_colour != 0 ? linear_of(line_colour) : line_colour) * alpha, alpha);
}
