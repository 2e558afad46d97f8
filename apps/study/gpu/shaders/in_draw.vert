// Comes after primitive.vert: cylinders outside the frustum get no proxy.
#include "box_test.glsl"
#undef main

void main() {
  int place = 2 * int(record_of(1u));
  vec3 low = texelFetch(boxes, place).xyz, high = texelFetch(boxes, place + 1).xyz;
  bool rejected = outside(low, high);
  gl_Position = vec4(0.0);
  setup.proxy = kNothing;
  if (rejected) return;
  place_proxy();
  setup.proxy.corners = kBoxCorners;  // as many triangles for each tell how many passed
}
