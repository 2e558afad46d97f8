// Slice of a circular torus in units of its larger radius. Derivation: gpuprims/circular_torus.h. item.extra = tube radius;
// texel 4: (major radius, angle, cos angle, sin angle).

const int kTexelsPerItem = 5;
const float kPi = 3.14159265358979;
const float kFullTurn = 6.2831850;  // a little less than 2 pi: seams of full tori have no end caps

#ifdef VERTEX_STAGE
LocalBox local_box(Item item, uint instance) {
  vec4 shape = payload_floats(instance, kTexelsPerItem, 4);
  float tube = item.extra, outer = shape.x + tube, inner = shape.x - tube, angle = shape.y;
  vec3 low = vec3(-outer, -outer, -tube), high = vec3(outer, outer, tube);
  if (inner >= 0.0 && angle < kFullTurn) {
    float c = shape.z, s = shape.w;
    if (angle < kPi) low.x = c * (c < 0.0 ? outer : inner);
    if (angle < 0.5 * kPi) high.y = s * outer;
    if (angle <= kPi) low.y = 0.0;
    else if (angle < 1.5 * kPi) low.y = s * outer;
  }
  return LocalBox(low, high);
}
#endif

#ifdef FRAGMENT_STAGE
struct TorusShape {
  float major, tube, angle;
  vec2 end;  // direction of the last disc
};

// (rho - R)^2 + z^2 - r^2 and its derivative along the ray: the form that stays exact for thin tori.
vec2 torus_value(TorusShape s, vec3 o, vec3 d, float t) {
  vec3 p = o + t * d;
  float rho = length(p.xy), off = rho - s.major;
  float drho = rho > 0.0 ? dot(p.xy, d.xy) / rho : length(d.xy);
  return vec2(off * off + p.z * p.z - s.tube * s.tube, 2.0 * (off * drho + p.z * d.z));
}

bool in_sweep(TorusShape s, vec2 p) {
  if (s.angle >= kFullTurn) return true;
  bool after_start = p.y >= 0.0, before_end = p.x * s.end.y - p.y * s.end.x >= 0.0;
  return s.angle <= kPi ? after_start && before_end : after_start || before_end;
}

void offer_end(inout Search search, TorusShape s, vec3 o, vec3 d, float inv_length, vec2 radial, vec2 outward) {
  float speed = dot(d.xy, outward);
  if (speed == 0.0) return;
  float t = -dot(o.xy, outward) / speed;
  vec3 p = o + t * d;
  vec2 q = vec2(dot(p.xy, radial) - s.major, p.z);
  if (dot(q, q) <= s.tube * s.tube) offer(search, t * inv_length, vec3(outward, 0.0));
}

// Root of a monotone piece by Newton's method, kept inside the bracket by bisection.
float bracketed_root(TorusShape s, vec3 o, vec3 d, float low, float high, bool low_outside) {
  float t = 0.5 * (low + high);
  for (int i = 0; i < 24; ++i) {
    vec2 g = torus_value(s, o, d, t);
    if ((g.x > 0.0) == low_outside) low = t; else high = t;
    float next = t - g.x / g.y;
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    if (abs(next - t) <= 1e-7 * (1.0 + abs(t))) return next;
    t = next;
  }
  return t;
}

// Critical points of the quartic along the ray, rising: roots of t^3 + P t + Q.
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

void intersect_primitive(inout Search search, vec3 o, vec3 direction, float tube, uint instance, uint flags) {
  vec4 shape = payload_floats(instance, kTexelsPerItem, 4);
  TorusShape s = TorusShape(shape.x, tube, shape.y, shape.zw);
  float inv_length = inversesqrt(dot(direction, direction));
  vec3 d = direction * inv_length;

  if (s.angle < kFullTurn) {
    if ((flags & kBottomOpen) == 0u) offer_end(search, s, o, d, inv_length, vec2(1.0, 0.0), vec2(0.0, -1.0));
    if ((flags & kTopOpen) == 0u) offer_end(search, s, o, d, inv_length, s.end, vec2(-s.end.y, s.end.x));
  }

  float outer = s.major + tube, p = dot(o, o), reach2 = outer * outer - p;
  if (reach2 <= 0.0) return;
  float reach = sqrt(reach2);
  float R2 = s.major * s.major;
  float k = p + R2 - tube * tube;
  vec3 c;
  int count = critical_points(k - 2.0 * R2 * dot(d.xy, d.xy), -2.0 * R2 * dot(o.xy, d.xy), c);
  c = clamp(c, -reach, reach);

  float low = -reach;
  bool low_outside = true;
  for (int piece = 0; piece <= count; ++piece) {
    bool last = piece == count;
    float high = last ? reach : c[piece];
    bool high_outside = last || torus_value(s, o, d, high).x > 0.0;
    if (low_outside != high_outside) {
      float t = bracketed_root(s, o, d, low, high, low_outside);
      vec3 q = o + t * d;
      if (in_sweep(s, q.xy)) {
        float rho = length(q.xy);
        offer(search, t * inv_length, rho > 0.0 ? vec3(q.xy * (1.0 - s.major / rho), q.z) : vec3(0.0, 0.0, q.z));
      }
    }
    low = high;
    low_outside = high_outside;
  }
}
#endif
