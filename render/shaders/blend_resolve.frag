// The sums of transparent surfaces become a layer: render/internal/overlays.h.
#ifdef SAMPLES
layout(binding = 0) uniform sampler2DMS sums;
layout(binding = 1) uniform sampler2DMS let_pass;
layout(binding = 2) uniform sampler2DMS nearest;
#define WHICH gl_SampleID
#else
layout(binding = 0) uniform sampler2D sums;
layout(binding = 1) uniform sampler2D let_pass;
layout(binding = 2) uniform sampler2D nearest;
#define WHICH 0
#endif

layout(location = 0) out vec4 pixel;  // multiplied by its alpha

void main() {
  ivec2 place = ivec2(gl_FragCoord.xy);
  vec4 sum = texelFetch(sums, place, WHICH);
  if (sum.a <= 0.0) discard;
  float alpha = 1.0 - texelFetch(let_pass, place, WHICH).r;
  pixel = vec4(sum.rgb / sum.a * alpha, alpha);
  gl_FragDepth = texelFetch(nearest, place, WHICH).r;
}
