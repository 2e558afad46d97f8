// The records of a batch as texels: gpuprims/internal/packing.h.

layout(binding = 0) uniform usamplerBuffer payload;

#include "limits.glsl"

uvec4 payload_texel(uint record, int texels_per_record, int texel) {
  return texelFetch(payload, int(record) * texels_per_record + texel);
}

vec4 payload_floats(uint record, int texels_per_record, int texel) {
  return uintBitsToFloat(payload_texel(record, texels_per_record, texel));
}

// The linear part of a record's placement in its chunk.
mat3 chunk_from_local(uint record, int texels_per_record, out vec3 offset) {
  vec4 a = payload_floats(record, texels_per_record, 0);
  vec4 b = payload_floats(record, texels_per_record, 1);
  vec4 c = payload_floats(record, texels_per_record, 2);
  offset = c.yzw;
  return mat3(a.xyz, vec3(a.w, b.xy), vec3(b.zw, c.x));
}
