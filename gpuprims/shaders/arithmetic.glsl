// Handles cancellation. A discriminant is the difference of two terms, which are nearly equal where a ray grazes a
// solid. There it is computed again in pairs of floats. That affects silhouettes, a few pixels of many.
#include "pairs.glsl"

// Terms cancel when their difference is smaller than this part of them.
const float kCancels = 0.02;

float cross_product(vec2 a, vec2 b) { return a.x * b.y - a.y * b.x; }

// The discriminant of the line u + t v and the cone x^2 + y^2 = z^2: m.x^2 + m.y^2 - m.z^2 with m = u x v, which is positive when the
// line crosses the cone twice.
float exact_cone_discriminant(Pair3 u, Pair3 v) {
  Pair3 m = pair_cross(u, v), squares = pair_product(m, m);
  squares.high.z = -squares.high.z;
  squares.low.z = -squares.low.z;
  return pair_total(squares);
}
