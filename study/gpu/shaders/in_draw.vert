// Comes after primitive.vert. The planes are shared out among the vertices of a triangle, as Carlos has it: the corners
// of each differ in how many of their bits are set, 1, 2 or 3 (gpuscene's index pattern).
#include "box_test.glsl"
#undef main

flat out uint rejected;

void main() {
  int place = 2 * int(record_of(8u));
  vec3 low = texelFetch(boxes, place).xyz, high = texelFetch(boxes, place + 1).xyz;
  rejected = uint(is_empty(low, high));
  for (int k = bitCount(gl_VertexID & 7) - 1; k < view_planes.plane_count && rejected == 0u; k += 3)
    rejected = uint(rejects(k, low, high));
  gl_Position = vec4(0.0);
  if (rejected == 0u) place_proxy();
}
