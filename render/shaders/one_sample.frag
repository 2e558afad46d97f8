// One sample of each pixel, the same one of its depth and of all else that must not be averaged.
layout(binding = 0) uniform sampler2DMS depths;
#if IDS
layout(binding = 1) uniform usampler2DMS ids;
layout(location = 1) out uint id;
#endif
#if NORMALS
layout(binding = 2) uniform sampler2DMS normals;
layout(location = 2) out vec4 normal;
#endif

void main() {
  ivec2 place = ivec2(gl_FragCoord.xy);
  gl_FragDepth = texelFetch(depths, place, 0).r;
#if IDS
  id = texelFetch(ids, place, 0).x;
#endif
#if NORMALS
  normal = texelFetch(normals, place, 0);
#endif
}
