// The part of a ray within an infinite cylinder about z: gpuprims/internal/local_ray.h.
#include "arithmetic.glsl"
#include "search.glsl"

// Narrows `span` to that part. False: nothing is left.
bool cylinder_span(vec3 o, vec3 d, float radius, int face, inout Span span) {
  float a = dot(d.xy, d.xy), r2 = radius * radius;
  if (!(a > 0.0)) return dot(o.xy, o.xy) <= r2;
  // The line passes the axis at distance |c| / sqrt(a): half a chord is sqrt(a r^2 - c^2) / a.
  float c = cross_product(o.xy, d.xy), square = a * r2, rest = square - c * c;
  if (abs(rest) < kCancels * square)
    rest = exact_cone_discriminant(Pair3(vec3(o.xy, radius), vec3(0.0)), Pair3(vec3(d.xy, 0.0), vec3(0.0)));
  if (!(rest >= 0.0)) return false;
  float middle = -dot(o.xy, d.xy) / a, half_chord = sqrt(rest) / a;
  enter(span, middle - half_chord, face);
  leave(span, middle + half_chord, face);
  return true;
}
