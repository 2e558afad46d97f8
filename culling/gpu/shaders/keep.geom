// Writes the indices of what the vertex stage kept, through transform feedback.
layout(points) in;
layout(points, max_vertices = 2) out;

#include "cull_limits.glsl"
#include "count_in_view.glsl"

flat in uint name[];
flat out uint found;

void main() {
  count_in_view();
  if (name[0] == kRejected) return;
  found = name[0];
  EmitVertex();
}
