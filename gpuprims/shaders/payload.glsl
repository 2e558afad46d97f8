// The records of a batch as texels: gpuprims/internal/packing.h.

layout(binding = 0) uniform usamplerBuffer payload;

#include "limits.glsl"

uvec4 payload_texel(uint record, int texels_per_record, int texel) {
  return texelFetch(payload, int(record) * texels_per_record + texel);
}

vec4 payload_floats(uint record, int texels_per_record, int texel) {
  return uintBitsToFloat(payload_texel(record, texels_per_record, texel));
}
