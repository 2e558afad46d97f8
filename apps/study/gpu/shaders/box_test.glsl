// One box against the planes of a view.

const int kMaxPlanes = 14;  // culling::kMaxCullPlanes

layout(std140, binding = 1) uniform StudyPlanes {
  vec4 planes[kMaxPlanes];  // normal, and an offset that errs outwards: below zero is surely outside
  int plane_count;
} view_planes;

layout(binding = 4) uniform samplerBuffer boxes;  // two texels each: min, max

// Whether the box is empty, or surely outside of a plane.
bool outside(vec3 low, vec3 high) {
  if (any(greaterThan(low, high))) return true;
  for (int k = 0; k < view_planes.plane_count; ++k) {
    vec4 p = view_planes.planes[k];
    vec3 corner = mix(low, high, greaterThanEqual(p.xyz, vec3(0.0)));
    precise float height = ((p.x * corner.x + p.y * corner.y) + p.z * corner.z) + p.w;
    if (height < 0.0) return true;
  }
  return false;
}
