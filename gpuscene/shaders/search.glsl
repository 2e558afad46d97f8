// Finds the end of a list that a culler has written. C++ side and defines: gpuscene/gpu_draw_lists.cpp.
#include "draw_commands.glsl"

layout(binding = 0) uniform usamplerBuffer records;   // ids, by place in DrawLists' list of single records
layout(binding = 1) uniform usamplerBuffer commands;  // gpuscene::ElementsCommand, five texels each

const uint kUnused = 0xffffffffu;

bool used(uint kind, uint place) {
  if (kind == MESH_KIND) return texelFetch(commands, int(COMMAND_WORDS * (sections[kind].x + place) + 1u)).x != 0u;
  return texelFetch(records, int(sections[kind].y + place)).x != kUnused;
}

// First unused place from `begin` on, or `end`.
uint search(uint kind, uint begin, uint end) {
  while (begin < end) {
    uint middle = (begin + end) / 2u;
    if (used(kind, middle)) begin = middle + 1u; else end = middle;
  }
  return begin;
}
