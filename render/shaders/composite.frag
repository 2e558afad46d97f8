// What a target shows, for a framebuffer. LAYER: where its alpha is not 0, with colours that are multiplied by it;
// IMAGE: where its depth says that anything is drawn. SAMPLES: of its pixels; without it one. EACH_SAMPLE: the
// framebuffer has as many, and gets each of them; otherwise WHOLE_PIXELS: their mean, at the nearest of their depths.
#include "srgb.glsl"

layout(location = 0) uniform ivec2 corner;        // of the target in the framebuffer, pixels
layout(location = 1) uniform vec2 window_depths;  // at the near and at the far plane
layout(location = 2) uniform int linear_colour;

#ifdef SAMPLES
layout(binding = 0) uniform sampler2DMS colours;
layout(binding = 1) uniform sampler2DMS depths;
#else
layout(binding = 0) uniform sampler2D colours;
layout(binding = 1) uniform sampler2D depths;
#endif

#if defined(SAMPLES) && defined(EACH_SAMPLE)
const int kCount = 1;
#define SAMPLE(i) gl_SampleID
#elif defined(SAMPLES)
const int kCount = SAMPLES;
#define SAMPLE(i) i
#else
const int kCount = 1;
#define SAMPLE(i) 0
#endif

layout(location = 0) out vec4 pixel;  // multiplied by its alpha

void main() {
  ivec2 place = ivec2(gl_FragCoord.xy) - corner;
  vec4 sum = vec4(0.0);
  float nearest = 0.0;  // reverse-Z; 0: nothing is drawn there
  for (int i = 0; i < kCount; ++i) {
    float depth = texelFetch(depths, place, SAMPLE(i)).r;
    vec4 texel = texelFetch(colours, place, SAMPLE(i));
#ifdef LAYER
    if (texel.a == 0.0) continue;
#else
    if (depth == 0.0) continue;
    texel.a = 1.0;
#endif
    nearest = max(nearest, depth);
    sum += texel;
  }
  if (sum.a == 0.0) discard;
  gl_FragDepth = window_depths.y + (window_depths.x - window_depths.y) * nearest;
  pixel = (linear_colour != 0 ? vec4(linear_of(sum.rgb / sum.a) * sum.a, sum.a) : sum) / float(kCount);
}
