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

// Bits of the faces (search.glsl) that an item does not show: its ends, and what stands in for them.
uint hidden_faces(uint material_word) {
  return ((material_word & kBottomOpen) != 0u ? 1u << 1 | 1u << 8 : 0u) | ((material_word & kTopOpen) != 0u ? 1u << 2 | 1u << 9 : 0u);
}
