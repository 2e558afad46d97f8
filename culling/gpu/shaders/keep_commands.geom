// Writes the draw commands of meshes that the vertex stage kept, through transform feedback. Records whose parts are
// drawn have a command without indices: it is not written, but counted as a point of a third stream.
layout(points) in;
layout(points, max_vertices = 2) out;

layout(binding = 4) uniform usamplerBuffer commands;  // gpuscene::ElementsCommand, five texels each

#include "cull_limits.glsl"
#include "count_in_view.glsl"
#ifdef PARTS
#include "part_data.glsl"
#endif

layout(location = 0) flat in uint name[];
layout(location = 0) flat out uvec4 command;  // index count, instance count, first index, base vertex
layout(location = 1) flat out uint base_instance;

void write(uint words[COMMAND_WORDS]) {
  command = uvec4(words[0], words[1], words[2], words[3]);
  base_instance = words[4];
  EmitVertex();
}

void main() {
  count_in_view();
  if (name[0] == kRejected) return;
#ifdef PARTS
  if (of_parts != 0) {
    write(command_of_part(name[0]));
    return;
  }
  if (texelFetch(commands, int(COMMAND_WORDS * name[0])).x == 0u) {
    EmitStreamVertex(2);
    EndStreamPrimitive(2);
    return;
  }
#endif
  uint words[COMMAND_WORDS];
  for (uint i = 0u; i < COMMAND_WORDS; ++i) words[i] = texelFetch(commands, int(COMMAND_WORDS * name[0] + i)).x;
  write(words);
}
