// Writes a vector and a scalar for even vertices, and emits odd ones into a stream that nobody writes.
layout(points) in;
layout(points, max_vertices = 1) out;

layout(location = 0) flat in uint name[];
layout(stream = 0, location = 0) flat out uvec4 first;
layout(stream = 0, location = 1) flat out uint last;
layout(stream = 1, location = 2) flat out uint counted;

void main() {
  if ((name[0] & 1u) == 0u) {
    first = 5u * name[0] + uvec4(0u, 1u, 2u, 3u);
    last = 5u * name[0] + 4u;
    EmitStreamVertex(0);
    EndStreamPrimitive(0);
  } else {
    counted = name[0];
    EmitStreamVertex(1);
    EndStreamPrimitive(1);
  }
}
