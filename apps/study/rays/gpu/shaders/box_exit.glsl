#include "box.glsl"

// Parameter where the ray leaves the box, and the axis of the face there.
float exit_of(Box b, out uint axis) {
  vec3 low = low_of(b), high = high_of(b);
  axis = 0u;
  float exit = at(0u, negative(0u) ? low.x : high.x);
  for (uint a = 1u; a < 3u; ++a) {
    float t = at(a, negative(a) ? low[a] : high[a]);
    if (t < exit) {
      exit = t;
      axis = a;
    }
  }
  return exit;
}
