// Snout (truncated cone, eccentric, slanted ends) in units of its larger radius. Derivation: gpuprims/snout.h. item.extra = height;
// texels 4 … 6: (bottom radius, top radius, offset x, y), (bottom slant x, y, top slant x, y), (lowest z, highest z, -, -).

const int kTexelsPerItem = 7;

struct SnoutShape {
  float bottom_radius, top_radius, height;
  vec2 offset, bottom_slant, top_slant;
  float low, high;
};

SnoutShape fetch_shape(uint instance, float height) {
  vec4 a = payload_floats(instance, kTexelsPerItem, 4);
  vec4 b = payload_floats(instance, kTexelsPerItem, 5);
  vec4 c = payload_floats(instance, kTexelsPerItem, 6);
  return SnoutShape(a.x, a.y, height, a.zw, b.xy, b.zw, c.x, c.y);
}

#ifdef VERTEX_STAGE
LocalBox local_box(Item item, uint instance) {
  SnoutShape s = fetch_shape(instance, item.extra);
  if (s.height == 0.0) {
    vec2 reach = 0.5 * abs(s.offset) + max(s.bottom_radius, s.top_radius);
    return LocalBox(vec3(-reach, s.low), vec3(reach, s.high));
  }
  // The circles of the cone at the lowest and highest z bound everything between.
  vec2 c0 = s.offset * (s.low / s.height), c1 = s.offset * (s.high / s.height);
  float slope = (s.top_radius - s.bottom_radius) / s.height;
  float mean = 0.5 * (s.bottom_radius + s.top_radius);
  float r0 = max(0.0, mean + slope * s.low), r1 = max(0.0, mean + slope * s.high);
  return LocalBox(vec3(min(c0 - r0, c1 - r1), s.low), vec3(max(c0 + r0, c1 + r1), s.high));
}
#endif

#ifdef FRAGMENT_STAGE
void offer_disc(inout Search search, vec3 o, vec3 d, vec2 centre, float radius, float facing) {
  if (d.z == 0.0) return;
  float t = -o.z / d.z;
  vec2 p = o.xy + t * d.xy - centre;
  if (dot(p, p) <= radius * radius) offer(search, t, vec3(0.0, 0.0, facing));
}

void intersect_primitive(inout Search search, vec3 o, vec3 d, float height, uint instance, uint flags) {
  SnoutShape s = fetch_shape(instance, height);
  bool open_bottom = (flags & kBottomOpen) != 0u, open_top = (flags & kTopOpen) != 0u;
  if (s.height == 0.0) {
    if (!open_bottom) offer_disc(search, o, d, -0.5 * s.offset, s.bottom_radius, -1.0);
    if (!open_top) offer_disc(search, o, d, 0.5 * s.offset, s.top_radius, 1.0);
    return;
  }
  const int kLateral = 0, kBottom = 1, kTop = 2;

  // u(t) = xy - centre(z) and r(z) are linear in t; the cone's inside is |u|^2 <= r^2 with r >= 0.
  vec2 lean = s.offset / s.height;
  float slope = (s.top_radius - s.bottom_radius) / s.height;
  vec2 u0 = o.xy - lean * o.z, u1 = d.xy - lean * d.z;
  float r0 = 0.5 * (s.bottom_radius + s.top_radius) + slope * o.z, r1 = slope * d.z;

  float t0 = -kNoHit, t1 = kNoHit;
  int side0 = kLateral, side1 = kLateral;
  float a = dot(u1, u1) - r1 * r1, b = dot(u0, u1) - r0 * r1;
  if (abs(a) > 1e-7 * (dot(u1, u1) + r1 * r1)) {
    // b^2 - a c, expanded so that its large equal terms are gone: |r1 u0 - r0 u1|^2 - (u0 x u1)^2.
    vec2 w = r1 * u0 - r0 * u1;
    float cross_u = u0.x * u1.y - u0.y * u1.x;
    float disc = dot(w, w) - cross_u * cross_u;
    if (disc < 0.0) {
      if (a > 0.0) return;                        // passes outside the nappes
      disc = 0.0;
    }
    float root = sqrt(disc);
    float q = b >= 0.0 ? -(b + root) : root - b;  // the root without cancellation; the other by Vieta
    float c = dot(u0, u0) - r0 * r0;
    float ta = q / a, tb = q != 0.0 ? c / q : ta;
    float first = min(ta, tb), last = max(ta, tb);
    bool first_real = r0 + first * r1 >= 0.0, last_real = r0 + last * r1 >= 0.0;
    if (a > 0.0) {
      if (!first_real && !last_real) return;      // the mirrored nappe
      t0 = first;
      t1 = last;
    } else if (r1 > 0.0) {                        // steeper than the cone: inside from the real nappe onwards
      t0 = last;
    } else {
      t1 = first;
    }
  } else if (b != 0.0) {                          // parallel to a side line: one crossing
    float t = -0.5 * (dot(u0, u0) - r0 * r0) / b;
    if (b > 0.0) t1 = t; else t0 = t;
  } else if (dot(u0, u0) > r0 * r0) {
    return;
  }

  float reach = 0.5 * s.height;
  vec2 bottom_centre = -0.5 * s.offset, top_centre = 0.5 * s.offset;
  clip_interval(o.z + reach - dot(s.bottom_slant, o.xy - bottom_centre), d.z - dot(s.bottom_slant, d.xy), kBottom, t0, t1,
                side0, side1);
  clip_interval(reach - o.z + dot(s.top_slant, o.xy - top_centre), dot(s.top_slant, d.xy) - d.z, kTop, t0, t1, side0,
                side1);
  if (t0 > t1) return;
  for (int i = 0; i < 2; ++i) {
    int side = i == 0 ? side0 : side1;
    float t = i == 0 ? t0 : t1;
    if (abs(t) >= kNoHit || (side == kBottom && open_bottom) || (side == kTop && open_top)) continue;
    vec3 normal;
    if (side == kLateral) {
      vec2 u = u0 + t * u1;
      normal = vec3(u, -dot(u, lean) - slope * (r0 + t * r1));
    } else {
      normal = side == kBottom ? vec3(s.bottom_slant, -1.0) : vec3(-s.top_slant, 1.0);
    }
    offer(search, t, normal);
  }
}
#endif
