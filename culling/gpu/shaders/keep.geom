// Writes the names of what the vertex stage kept, through transform feedback.
layout(points) in;
layout(points, max_vertices = 1) out;

flat in uint kept[];
flat in uint name[];
flat out uint found;

void main() {
  if (kept[0] == 0u) return;
  found = name[0];
  EmitVertex();
}
