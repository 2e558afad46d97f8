// Sphere, elliptical dish and spherical dish: the unit ball above the plane z = k, under each kind's own scale. item.extra = k: -1 for a
// sphere, 0 for an elliptical dish (half a ball, stretched), (R - h) / R for a spherical dish of sphere radius R.

const int kTexelsPerItem = 4;

#ifdef VERTEX_STAGE
LocalBox local_box(Item item, uint instance) {
  float k = item.extra;
  float reach = k > 0.0 ? sqrt(max(1.0 - k * k, 0.0)) : 1.0;
  return LocalBox(vec3(-reach, -reach, k), vec3(reach, reach, 1.0));
}
#endif

#ifdef FRAGMENT_STAGE
void intersect_primitive(inout Search search, vec3 o, vec3 d, float k, uint instance, uint flags) {
  const int kRound = 0, kBase = 1;
  // The origin is the ray's closest approach to the centre: o.d = 0, and the half chord follows without cancellation.
  float rest = 1.0 - dot(o, o);
  if (rest < 0.0) return;
  float chord = sqrt(rest / dot(d, d));
  float t0 = -chord, t1 = chord;
  int side0 = kRound, side1 = kRound;
  clip_interval(o.z - k, d.z, kBase, t0, t1, side0, side1);
  if (t0 > t1) return;
  bool open_base = (flags & kBottomOpen) != 0u;
  for (int i = 0; i < 2; ++i) {
    int side = i == 0 ? side0 : side1;
    float t = i == 0 ? t0 : t1;
    if (side == kBase && open_base) continue;
    offer(search, t, side == kRound ? o + t * d : vec3(0.0, 0.0, -1.0));
  }
}
#endif
