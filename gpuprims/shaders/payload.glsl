// The records of a batch as texels: gpuprims/packing.h.

layout(binding = 0) uniform usamplerBuffer payload;

const uint kBottomOpen = 1u << 24;
const uint kTopOpen = 1u << 25;
const uint kFlatShaded = 1u << 26;

uvec4 payload_texel(uint record, int texels_per_item, int texel) {
  return texelFetch(payload, int(record) * texels_per_item + texel);
}

vec4 payload_floats(uint record, int texels_per_item, int texel) {
  return uintBitsToFloat(payload_texel(record, texels_per_item, texel));
}
