// A picture for a framebuffer of the application's. SAMPLES: of a pixel of the picture; without it one. EACH_SAMPLE: the
// framebuffer has as many, and gets each of them. LAYER: a layer instead, to be blended over what is there; its colours
// are multiplied by their alpha.
layout(location = 0) uniform ivec2 corner;        // of the picture in the framebuffer, pixels
layout(location = 1) uniform vec2 window_depths;  // at the near and at the far plane
layout(location = 2) uniform bool linear_colour;

#ifdef SAMPLES
layout(binding = 0) uniform sampler2DMS colours;
layout(binding = 1) uniform sampler2DMS depths;
#else
layout(binding = 0) uniform sampler2D colours;
layout(binding = 1) uniform sampler2D depths;
#endif

out vec4 pixel;

// IEC 61966-2-1.
vec3 linear_of(vec3 srgb) {
  return mix(srgb / 12.92, pow((srgb + 0.055) / 1.055, vec3(2.4)), greaterThan(srgb, vec3(0.04045)));
}

// A pixel of a layer, and its nearest depth.
#ifdef LAYER
vec4 layer_at(ivec2 place, out float depth) {
#if defined(SAMPLES) && !defined(EACH_SAMPLE)
  vec4 sum = vec4(0.0);
  depth = 0.0;
  for (int i = 0; i < SAMPLES; ++i) {
    vec4 texel = texelFetch(colours, place, i);
    if (texel.a == 0.0) continue;
    depth = max(depth, texelFetch(depths, place, i).r);
    sum += texel;
  }
  return sum / float(SAMPLES);
#else
#ifdef SAMPLES
  int layer = gl_SampleID;
#else
  int layer = 0;
#endif
  depth = texelFetch(depths, place, layer).r;
  return texelFetch(colours, place, layer);
#endif
}

void main() {
  float depth;
  vec4 shown = layer_at(ivec2(gl_FragCoord.xy) - corner, depth);
  if (shown.a == 0.0) discard;
  gl_FragDepth = window_depths.y + (window_depths.x - window_depths.y) * depth;
  pixel = linear_colour ? vec4(linear_of(shown.rgb / shown.a) * shown.a, shown.a) : shown;
}
#else
void main() {
  ivec2 place = ivec2(gl_FragCoord.xy) - corner;
  vec3 colour = vec3(0.0);
  float depth = 0.0;  // reverse-Z; 0: nothing is drawn there
  float coverage = 1.0;
#if defined(SAMPLES) && !defined(EACH_SAMPLE)
  int covered = 0;
  for (int i = 0; i < SAMPLES; ++i) {
    float at = texelFetch(depths, place, i).r;
    if (at == 0.0) continue;
    depth = max(depth, at);
    colour += texelFetch(colours, place, i).rgb;
    ++covered;
  }
  colour /= float(max(covered, 1));
  coverage = float(covered) / float(SAMPLES);
#else
#ifdef SAMPLES
  int layer = gl_SampleID;
#else
  int layer = 0;
#endif
  depth = texelFetch(depths, place, layer).r;
  colour = texelFetch(colours, place, layer).rgb;
#endif
  if (depth == 0.0) discard;
  gl_FragDepth = window_depths.y + (window_depths.x - window_depths.y) * depth;
  pixel = vec4(linear_colour ? linear_of(colour) : colour, coverage);
}
#endif
