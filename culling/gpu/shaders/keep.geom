// Writes the indices of what the vertex stage kept, through transform feedback.
layout(points) in;
layout(points, max_vertices = 2) out;

#include "cull_limits.glsl"
#include "count_in_view.glsl"

layout(location = 0) flat in uint name[];
layout(location = 0) flat out uint found;

void main() {
  count_in_view();
  if (name[0] == kRejected) return;
  found = name[0];
  EmitVertex();
}
