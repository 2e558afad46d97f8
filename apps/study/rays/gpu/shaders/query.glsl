// The questions of a traversal (query.h), and the one intersection that all share (triangle_set.cpp): operation by
// operation as on the CPU. `precise` forbids what would round otherwise. Divisions, which GL does not promise to round
// correctly, are the CPU's, all but that by the determinant. Defines: ANY, COUNTING.
#include "space.glsl"

struct Ray {          // RayRecord of ray_batch.cpp
  dvec4 start;        // origin, its axes in the order of the triangle test; and the largest parameter
  dvec4 towards;      // direction, likewise; and UnitRay::entry
  dvec4 shear;        // and UnitRay::scale
  vec4 unit_origin;   // and exit; negative: the ray misses everything
  vec4 unit_direction;
  vec4 unit_inverse;  // and the axis of the triangle test's z
};
layout(std430, binding = 0) readonly restrict buffer Rays {
  Ray rays[];
};
layout(std430, binding = 2) readonly restrict buffer Corners {
  float corners[];  // nine a triangle
};
layout(std430, binding = 3) readonly restrict buffer Triangles {
  uint triangles[];  // of the leaves, each a range
};
const uint kNone = 0xffffffffu;

// Initialised, since compilers warn where they do not see that trace() sets them.
Ray ray = Ray(dvec4(0.0lf), dvec4(0.0lf), dvec4(0.0lf), vec4(0.0), vec4(0.0), vec4(0.0));
float ray_exit = 0.0;
double hit_t = 0.0lf;
uint hit_triangle = kNone;
float nearest = 0.0;  // parameter of the unit ray
uint nodes_visited = 0u, triangles_tested = 0u;

bool negative(uint axis) { return ray.unit_direction[axis] < 0.0; }

// Where the ray meets the plane at `position` across the axis.
float at(uint axis, float position) {
  precise float t = (position - ray.unit_origin[axis]) * ray.unit_inverse[axis];
  return t;
}

float point(uint axis, float t) {
  precise float p = ray.unit_origin[axis] + t * ray.unit_direction[axis];
  return p;
}

void visit() {
#ifdef COUNTING
  ++nodes_visited;
#endif
}

bool intersect(uint triangle, double t_max, out double t) {
  uint z = uint(ray.unit_inverse.w), x = z == 2u ? 0u : z + 1u, y = x == 2u ? 0u : x + 1u, c = 9u * triangle;
  vec3 a = vec3(corners[c + x], corners[c + y], corners[c + z]);
  vec3 b = vec3(corners[c + 3u + x], corners[c + 3u + y], corners[c + 3u + z]);
  vec3 d = vec3(corners[c + 6u + x], corners[c + 6u + y], corners[c + 6u + z]);
  precise dvec3 pa = dvec3(a) - ray.start.xyz;
  precise dvec3 pb = dvec3(b) - ray.start.xyz;
  precise dvec3 pd = dvec3(d) - ray.start.xyz;
  dvec3 along = dvec3(pa.z, pb.z, pd.z);
  precise dvec3 px = dvec3(pa.x, pb.x, pd.x) - ray.shear.x * along;
  precise dvec3 py = dvec3(pa.y, pb.y, pd.y) - ray.shear.y * along;
  precise dvec3 pz = ray.shear.z * along;
  precise double u = px.z * py.y - py.z * px.y;
  precise double v = px.x * py.z - py.x * px.z;
  precise double w = px.y * py.x - py.y * px.x;
  t = 0.0lf;
  if ((u < 0.0lf || v < 0.0lf || w < 0.0lf) && (u > 0.0lf || v > 0.0lf || w > 0.0lf)) return false;
  precise double determinant = u + v + w;
  if (determinant == 0.0lf) return false;
  precise double sum = u * pz.x + v * pz.y + w * pz.z;
  precise double parameter = sum / determinant;
  t = parameter;
  if (!(t >= 0.0lf && t <= t_max) || isinf(t)) return false;
  precise dvec3 p = ray.start.xyz + t * ray.towards.xyz;
  precise dvec3 lowest = dvec3(min(min(a, b), d)) - space.slack;
  precise dvec3 highest = dvec3(max(max(a, b), d)) + space.slack;
  return all(greaterThanEqual(p, lowest)) && all(lessThanEqual(p, highest));
}

// Tests the triangles of a leaf. True ends the search, as Query::test().
bool test(uint first, uint count, float exit) {
#ifdef COUNTING
  triangles_tested += count;
#endif
  for (uint k = first; k < first + count; ++k) {
    uint i = triangles[k];
    double t;
    if (!intersect(i, hit_t, t) || (t == hit_t && i >= hit_triangle)) continue;
    hit_t = t;
    hit_triangle = i;
#ifdef ANY
    return true;
#endif
    precise double from_entry = t * ray.shear.w - ray.towards.w;
    nearest = float(from_entry);
  }
  return nearest <= exit;
}
