// Writes the visible records of one batch, or the draw commands of its meshes, to their places.
#include "blocks.glsl"

#ifdef MESHES
layout(binding = 4) uniform usamplerBuffer commands;  // gpuscene::ElementsCommand of all meshes
#endif
layout(std430, binding = 2) writeonly restrict buffer Found {
  uint found[];
};
layout(location = 1) uniform uint first_word;  // of found

void main() {
  uint block = gl_WorkGroupID.x, i = gl_LocalInvocationIndex;
  uint mask = masks[mask_index(block, i)];
  if (mask == 0u) return;
  uint place = places[place_index(block, i)] - places[batch.z * gl_WorkGroupSize.x];
  for (; mask != 0u; mask &= mask - 1u, ++place) {
    uint record = (block * kClustersPerBlock + uint(findLSB(mask))) * gl_WorkGroupSize.x + i;
#ifdef MESHES
    for (uint word = 0u; word < COMMAND_WORDS; ++word)
      found[first_word + COMMAND_WORDS * place + word] = texelFetch(commands, int(COMMAND_WORDS * record + word)).x;
#else
    found[first_word + place] = record;
#endif
  }
}
