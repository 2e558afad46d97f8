// Slice of a circular torus in units of its larger radius, with the sweep's bisector along x. Derivation:
// gpuprims/internal/circular_torus.h. extra = tube radius; texel 4: (major radius, 1 when closed, cosine and sine of
// half the angle).
#include "arithmetic.glsl"
#include "wedge.glsl"

const float kPi = 3.14159265358979;

struct Shape {
  float major, tube_radius;
  bool closed;
  vec2 half_angle;
} shape;

void load_shape(uint record, float tube_radius, float shift) {
  vec4 sweep = payload_floats(record, TEXELS_PER_RECORD, 4);
  shape = Shape(sweep.x, tube_radius, sweep.y > 0.0, sweep.zw);
}

vec3 shape_reach() { return vec3(vec2(shape.major + shape.tube_radius), shape.tube_radius); }

// (rho - R)^2 + z^2 - r^2 and its derivative along the ray: the form that stays exact for thin tori.
vec2 torus_value(vec3 o, vec3 d, float t) {
  vec3 p = o + t * d;
  float rho = length(p.xy), off = rho - shape.major;
  float drho = rho > 0.0 ? dot(p.xy, d.xy) / rho : length(d.xy);
  return vec2(off * off + (p.z - shape.tube_radius) * (p.z + shape.tube_radius), 2.0 * (off * drho + p.z * d.z));
}

// Root of a monotone piece by Newton's method, kept inside the bracket by bisection.
float bracketed_root(vec3 o, vec3 d, float low, float high, bool low_outside) {
  float t = 0.5 * (low + high);
  for (int i = 0; i < 32; ++i) {
    vec2 g = torus_value(o, d, t);
    if ((g.x > 0.0) == low_outside) low = t; else high = t;
    float next = t - g.x / g.y;
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    float step_length = abs(next - t);
    t = next;
    if (step_length <= 6e-8 * (1.0 + abs(t))) break;
  }
  return t;
}

// Real roots of t^3 + P t + Q in rising order; returns their number.
int critical_points(float P, float Q, out vec3 t) {
  float third = P / 3.0, half_q = 0.5 * Q;
  float disc = half_q * half_q + third * third * third;
  int count;
  if (third < 0.0 && disc < 0.0) {
    float m = 2.0 * sqrt(-third);
    float angle = acos(clamp(half_q / (third * sqrt(-third)), -1.0, 1.0)) / 3.0;
    t = m * vec3(cos(angle - 4.0 * kPi / 3.0), cos(angle - 2.0 * kPi / 3.0), cos(angle));
    count = 3;
  } else {
    float w = abs(half_q) + sqrt(max(disc, 0.0));
    float c = w > 0.0 ? pow(w, 1.0 / 3.0) : 0.0;
    float x = c > 0.0 ? c - third / c : 0.0;
    t = vec3(half_q > 0.0 ? -x : x);
    count = 1;
  }
  for (int i = 0; i < 3; ++i) {
    float slope = 3.0 * t[i] * t[i] + P;
    if (abs(slope) > 1e-6) t[i] -= clamp((t[i] * t[i] * t[i] + P * t[i] + Q) / slope, -1e-2, 1e-2);
  }
  return count;
}

void intersect_primitive(inout Search search, vec3 o, vec3 direction) {
  float inv_length = inversesqrt(dot(direction, direction));
  vec3 d = direction * inv_length;
  float outer = shape.major + shape.tube_radius, p = dot(o, o), reach2 = outer * outer - p;
  if (!(reach2 > 0.0)) return;
  Span wedges[2];
  vec2 ends_reach = shape.tube_radius * vec2(internal_cap_overlap(search, kBottom), internal_cap_overlap(search, kTop));
  int wedge_count = wedge_spans(o, direction, shape.half_angle, shape.closed, ends_reach, wedges);
  if (wedge_count == 0) return;

  float reach = 1.0001 * sqrt(reach2);
  float R2 = shape.major * shape.major;
  float k = p + (shape.major - shape.tube_radius) * outer;
  vec3 c;
  int count = critical_points(k - 2.0 * R2 * dot(d.xy, d.xy), -2.0 * R2 * dot(o.xy, d.xy), c);
  c = clamp(c, -reach, reach);

  float low = -reach, entered = 0.0;
  bool low_outside = true;
  for (int piece = 0; piece <= count; ++piece) {
    bool last = piece == count;
    float high = last ? reach : c[piece];
    bool high_outside = last || torus_value(o, d, high).x > 0.0;
    if (low_outside != high_outside) {
      float t = bracketed_root(o, d, low, high, low_outside);
      if (low_outside) entered = t;
      else offer_swept(search, Span(entered * inv_length, t * inv_length, kSide, kSide), wedges, wedge_count);
    }
    low = high;
    low_outside = high_outside;
  }
}

vec3 face_normal(vec3 p, int face) {
  if (face != kSide) return sweep_end_normal(shape.half_angle, face);
  float rho = length(p.xy);
  return vec3(rho > 0.0 ? p.xy * (1.0 - shape.major / rho) : vec2(0.0), p.z);
}
