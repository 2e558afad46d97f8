// Writes the visible records of one batch, or the draw commands of its meshes or of their parts, to their places.
#include "blocks.glsl"
#ifdef PARTS
#include "part_data.glsl"
#endif

#ifdef MESHES
layout(binding = 4) uniform usamplerBuffer commands;  // gpuscene::ElementsCommand of all meshes
#endif
layout(std430, binding = 2) writeonly restrict buffer Found {
  uint found[];
};
layout(location = 1) uniform uint first_word;  // of found

#ifdef MESHES
uint[COMMAND_WORDS] command_of(uint name) {
#ifdef PARTS
  if (of_parts != 0) return command_of_part(name);
#endif
  uint words[COMMAND_WORDS];
  for (uint word = 0u; word < COMMAND_WORDS; ++word)
    words[word] = texelFetch(commands, int(COMMAND_WORDS * name + word)).x;
  return words;
}
#endif

void main() {
  uint block = gl_WorkGroupID.x, i = gl_LocalInvocationIndex;
  uint mask = masks[mask_index(block, i)];
  if (mask == 0u) return;
  uint place = places[place_index(block, i)] - places[batch.w * gl_WorkGroupSize.x];
  for (; mask != 0u; mask &= mask - 1u, ++place) {
    uint name = (block * kClustersPerBlock + uint(findLSB(mask))) * gl_WorkGroupSize.x + i;
#ifdef MESHES
    uint words[COMMAND_WORDS] = command_of(name);
    for (uint word = 0u; word < COMMAND_WORDS; ++word) found[first_word + COMMAND_WORDS * place + word] = words[word];
#else
    found[first_word + place] = name;
#endif
  }
}
