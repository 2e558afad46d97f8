// One box against the planes of a view. Defines choose what is tried out: SPLIT, PLANE_ORDER (see flat.h).

const int kMaxPlanes = 14;  // culling::kMaxCullPlanes

struct StudyPlane {
  vec4 outer;   // normal, and an offset that errs outwards: below zero is surely outside
  float inner;  // an offset that errs inwards: not below zero is surely inside
};

layout(std140, binding = 1) uniform StudyPlanes {
  StudyPlane planes[kMaxPlanes];
  int plane_count;
} view_planes;

layout(binding = 4) uniform samplerBuffer boxes;  // two texels each: min, max

uint all_planes() { return (1u << view_planes.plane_count) - 1u; }

float height(vec3 normal, vec3 corner, float offset) {
  precise float h = ((normal.x * corner.x + normal.y * corner.y) + normal.z * corner.z) + offset;
  return h;
}

#ifdef SPLIT
// A. Reshetov's form: no corner is chosen, as the half of each product that does not count is zero. All planes are
// computed before any answer is looked at.
float split_height(vec3 normal, vec3 low, vec3 high, float offset) {
  vec3 positive = max(normal, vec3(0.0)), negative = min(normal, vec3(0.0));
  precise vec3 terms = positive * high + negative * low;
  precise float h = ((terms.x + terms.y) + terms.z) + offset;
  return h;
}

// Whether the box is surely outside of a plane of `mask`; clears those that it lies inside of.
bool outside(vec3 low, vec3 high, inout uint mask, inout uint first) {
  uint rejecting = 0u, passing = 0u;
  for (int k = 0; k < view_planes.plane_count; ++k) {
    StudyPlane p = view_planes.planes[k];
    rejecting |= uint(split_height(p.outer.xyz, low, high, p.outer.w) < 0.0) << k;
    passing |= uint(split_height(p.outer.xyz, high, low, p.inner) >= 0.0) << k;
  }
  if ((rejecting & mask) != 0u) return true;
  mask &= ~passing;
  return false;
}
#else
bool rejects(int k, vec3 low, vec3 high) {
  vec4 p = view_planes.planes[k].outer;
  return height(p.xyz, mix(low, high, greaterThanEqual(p.xyz, vec3(0.0))), p.w) < 0.0;
}

// Whether the box is surely outside of a plane of `mask`, the last one that rejected it in front with PLANE_ORDER.
bool outside(vec3 low, vec3 high, inout uint mask, inout uint first) {
#ifdef PLANE_ORDER
  if ((mask >> first & 1u) != 0u && rejects(int(first), low, high)) return true;
#endif
  for (int k = 0; k < view_planes.plane_count; ++k) {
    if ((mask >> k & 1u) == 0u || !rejects(k, low, high)) continue;
    first = uint(k);
    return true;
  }
  return false;
}
#endif

// Planes of `mask` that the box is not surely inside of.
uint remaining(vec3 low, vec3 high, uint mask) {
  for (int k = 0; k < view_planes.plane_count; ++k) {
    vec3 n = view_planes.planes[k].outer.xyz;
    if (height(n, mix(high, low, greaterThanEqual(n, vec3(0.0))), view_planes.planes[k].inner) >= 0.0)
      mask &= ~(1u << k);
  }
  return mask;
}

bool is_empty(vec3 low, vec3 high) { return any(greaterThan(low, high)); }
