// Writes the draw commands of meshes that the vertex stage kept, through transform feedback.
layout(points) in;
layout(points, max_vertices = 2) out;

layout(binding = 4) uniform usamplerBuffer commands;  // gpuscene::ElementsCommand, five texels each

#include "cull_limits.glsl"
#include "count_in_view.glsl"

flat in uint name[];
flat out uvec4 command;  // index count, instance count, first index, base vertex
flat out uint base_instance;

void main() {
  count_in_view();
  if (name[0] == kRejected) return;
  int at = 5 * int(name[0]);
  for (int i = 0; i < 4; ++i) command[i] = texelFetch(commands, at + i).x;
  base_instance = texelFetch(commands, at + 4).x;
  EmitVertex();
}
