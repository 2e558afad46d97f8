// Ray-cast primitives in three.js: those of primitive.frag, with depth and colour as the renderer has them.
#extension GL_EXT_conservative_depth : enable
#include "es.glsl"
#define PLAIN_DEPTH
#if defined(GL_EXT_conservative_depth) && !defined(LOGARITHMIC_DEPTH)
#ifdef REVERSED_DEPTH
layout(depth_less) out float gl_FragDepth;
#else
layout(depth_greater) out float gl_FragDepth;
#endif
#endif
#define main cast_and_shade
#include "primitive.frag"
#undef main
#include "srgb.glsl"

uniform bool linear_colour;             // the target holds light, not sRGB values
uniform float logarithmic_depth_scale;  // 1 / log2(far + 1)

// Depth of the renderer's buffer.
float target_depth(float depth) {
#if defined(REVERSED_DEPTH)
  return depth;
#elif defined(LOGARITHMIC_DEPTH)
  mat4 clip = view.clip_from_eye;
  float distance = (clip[3].z - depth * clip[3].w) / (clip[2].z - depth * clip[2].w);
  return perspective_view() ? log2(1.0 + distance) * logarithmic_depth_scale : 1.0 - depth;
#else
  return max(1.0 - depth, gl_FragCoord.z);  // depth_greater must hold despite rounding
#endif
}

void main() {
  cast_and_shade();
  gl_FragDepth = target_depth(gl_FragDepth);
  if (linear_colour) out_colour.rgb = linear_of(out_colour.rgb);
}
