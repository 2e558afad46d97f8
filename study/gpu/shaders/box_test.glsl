// One box against the planes of a view.

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

float height(vec3 normal, vec3 corner, float offset) {
  precise float h = ((normal.x * corner.x + normal.y * corner.y) + normal.z * corner.z) + offset;
  return h;
}

// Whether the box is surely outside of a plane.
bool outside(vec3 low, vec3 high) {
  for (int k = 0; k < view_planes.plane_count; ++k) {
    vec4 p = view_planes.planes[k].outer;
    if (height(p.xyz, mix(low, high, greaterThanEqual(p.xyz, vec3(0.0))), p.w) < 0.0) return true;
  }
  return false;
}

// Whether the box is surely inside of all planes.
bool inside(vec3 low, vec3 high) {
  for (int k = 0; k < view_planes.plane_count; ++k) {
    vec3 n = view_planes.planes[k].outer.xyz;
    if (height(n, mix(high, low, greaterThanEqual(n, vec3(0.0))), view_planes.planes[k].inner) < 0.0) return false;
  }
  return true;
}

bool is_empty(vec3 low, vec3 high) { return any(greaterThan(low, high)); }
