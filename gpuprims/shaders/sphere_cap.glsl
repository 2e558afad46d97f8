// Sphere, elliptical dish and spherical dish: a cap of a ball of height c = extra, each under its kind's own scale.
//   c >= 1  the unit ball about the origin, above z = 1 - c: a sphere is c = 2, an elliptical dish c = 1 and stretched
//   c < 1   a flat cap above the unit circle in z = 0, of a ball of radius (1 + c^2) / 2c, which may be huge
#include "arithmetic.glsl"
#include "search.glsl"

struct Shape {
  float c;
} shape;

void load_shape(uint record, float c, float shift) { shape = Shape(c); }

vec3 shape_reach() { return vec3(1.0); }

bool ball(vec3 o, vec3 d, inout Span span) {
  // The line passes the centre at distance |o x d| / |d|.
  float a = dot(d, d);
  vec3 m = cross(o, d);
  float rest = a - dot(m, m);
  if (abs(rest) < kCancels * a) {
    Pair3 exact_m = pair_cross(Pair3(o, vec3(0.0)), Pair3(d, vec3(0.0)));
    rest = pair_total(pair_sum(pair_product(d, d), pair_negative(pair_product(exact_m, exact_m))));
  }
  if (!(rest >= 0.0)) return false;
  float middle = -dot(o, d) / a, half_chord = sqrt(rest) / a;
  enter(span, middle - half_chord, kSide);
  leave(span, middle + half_chord, kSide);
  return true;
}

// The ball that a flat cap is cut from: x^2 + y^2 + z^2 - 1 + z (1 - c^2) / c <= 0, times c.
bool flat_ball(vec3 o, vec3 d, inout Span span) {
  float c = shape.c, slope = (1.0 - c) * (1.0 + c);
  float a = c * dot(d, d), b = c * dot(o, d) + 0.5 * slope * d.z;
  float rho = dot(o.xy, o.xy) - 1.0;
  float f = c * (rho + o.z * o.z) + slope * o.z;
  float rest = b * b - a * f;
  if (!(rest >= 0.0)) return false;
  float root = sqrt(rest), q = b >= 0.0 ? -(b + root) : root - b;
  float t0 = a > 0.0 ? q / a : (q >= 0.0 ? kNoHit : -kNoHit), t1 = q != 0.0 ? f / q : t0;
  enter(span, min(t0, t1), kSide);
  leave(span, max(t0, t1), kSide);
  return true;
}

void intersect_primitive(inout Search search, vec3 o, vec3 d) {
  Span span = whole_line();
  float start = 0.0;
  if (shape.c < 1.0) {
    start = move_to_level(o, d, 2.0);  // to the base plane, whose disc decides exactly which rays enter
    if (!flat_ball(o, d, span)) return;
    clip(span, o.z, d.z, kBottom);  // even if hidden: below it the ball is wider than the neighbour that covers it
  } else {
    if (!ball(o, d, span)) return;
    if (shape.c < 2.0) clip(span, o.z - (1.0 - shape.c) + internal_cap_overlap(search, kBottom), d.z, kBottom);
  }
  offer_span(search, span, start);
}

vec3 face_normal(vec3 p, int face) {
  if (face == kBottom) return vec3(0.0, 0.0, -1.0);
  float c = shape.c;
  return c < 1.0 ? vec3(c * p.xy, c * p.z + 0.5 * (1.0 - c) * (1.0 + c)) : p;
}
