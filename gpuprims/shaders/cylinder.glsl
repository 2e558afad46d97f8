// Cylinder in units of its radius: x^2 + y^2 <= 1, |z| <= h / 2, item.extra = h. Derivation: gpuprims/cylinder.h.

const int kTexelsPerItem = 4;

#ifdef VERTEX_STAGE
LocalBox local_box(Item item, uint instance) {
  vec3 reach = vec3(1.0, 1.0, 0.5 * item.extra);
  return LocalBox(-reach, reach);
}
#endif

#ifdef FRAGMENT_STAGE
void intersect_primitive(inout Search search, vec3 o, vec3 d, float height, uint instance, uint flags) {
  const int kLateral = 0, kBottom = 1, kTop = 2;
  float t0 = -kNoHit, t1 = kNoHit;
  int side0 = kLateral, side1 = kLateral;
  float a = dot(d.xy, d.xy);
  if (a > 0.0) {
    // Half-chord form: the discriminant is taken at the closest approach to the axis, where nothing cancels.
    float tc = -dot(o.xy, d.xy) / a;
    vec2 q = o.xy + tc * d.xy;
    float rest = 1.0 - dot(q, q);
    if (rest < 0.0) return;
    float chord = sqrt(rest / a);
    t0 = tc - chord;
    t1 = tc + chord;
  } else if (dot(o.xy, o.xy) > 1.0) {
    return;
  }
  float reach = 0.5 * height;
  clip_interval(o.z + reach, d.z, kBottom, t0, t1, side0, side1);
  clip_interval(reach - o.z, -d.z, kTop, t0, t1, side0, side1);
  if (t0 > t1) return;
  bool open_bottom = (flags & kBottomOpen) != 0u, open_top = (flags & kTopOpen) != 0u;
  for (int i = 0; i < 2; ++i) {
    int side = i == 0 ? side0 : side1;
    float t = i == 0 ? t0 : t1;
    if ((side == kBottom && open_bottom) || (side == kTop && open_top)) continue;
    offer(search, t, side == kLateral ? vec3(o.xy + t * d.xy, 0.0) : vec3(0.0, 0.0, side == kBottom ? -1.0 : 1.0));
  }
}
#endif
