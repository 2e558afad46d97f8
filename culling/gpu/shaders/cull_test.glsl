// Tests of boxes against the planes of a view: the float half of culling/frustum/frustum_test.h, evaluated in the same order. A
// box is culled only when a plane surely rejects it. A box that the float form leaves open is kept.

#include "cull_limits.glsl"
#include "selection.glsl"

struct CullPlane {
  vec4 equation;  // normal, offset
  float band;     // every error is smaller
};

layout(std140, binding = 1) uniform CullBlock {
  CullPlane planes[kMaxPlanes];
  int union_first, plane_count;  // planes from union_first on: one of them must be met
  uint view_layers;
  bool use_layers;
  // For parts of meshes: lod::MeshError's w(), error_per_w(), nearest_w() and sections().
  vec4 w;
  float error_per_w, nearest_w;
  int frustum_planes;  // the first ones
  int section_count;
  vec4 sections[kMaxSections];
} cull;

layout(binding = 0) uniform samplerBuffer cluster_boxes;    // two texels each: min, max
layout(binding = 1) uniform usamplerBuffer cluster_layers;  // union over the cluster's items

float plane_at(vec4 plane, vec3 corner) {
  precise float s = ((plane.x * corner.x + plane.y * corner.y) + plane.z * corner.z) + plane.w;
  return s;
}

bool surely_outside(CullPlane plane, vec3 low, vec3 high) {
  return plane_at(plane.equation, mix(low, high, greaterThanEqual(plane.equation.xyz, vec3(0.0)))) < -plane.band;
}

bool surely_inside(CullPlane plane, vec3 low, vec3 high) {
  return plane_at(plane.equation, mix(high, low, greaterThanEqual(plane.equation.xyz, vec3(0.0)))) >= plane.band;
}

bool outside_one_of(int count, vec3 low, vec3 high) {
  for (int i = 0; i < count; ++i)
    if (surely_outside(cull.planes[i], low, high)) return true;
  return false;
}

bool outside(vec3 low, vec3 high) {
  if (outside_one_of(cull.union_first, low, high)) return true;
  if (cull.union_first == cull.plane_count) return false;
  for (int i = cull.union_first; i < cull.plane_count; ++i)
    if (!surely_outside(cull.planes[i], low, high)) return false;
  return true;
}

bool inside(vec3 low, vec3 high) {
  for (int i = 0; i < cull.union_first; ++i)
    if (!surely_inside(cull.planes[i], low, high)) return false;
  if (cull.union_first == cull.plane_count) return true;
  for (int i = cull.union_first; i < cull.plane_count; ++i)
    if (surely_inside(cull.planes[i], low, high)) return true;
  return false;
}

// Returns the cluster, with kInsideBit set where no plane cuts it, or kRejected. Empty clusters hold the inverted box.
uint test_cluster(uint cluster) {
  vec3 low = texelFetch(cluster_boxes, 2 * int(cluster)).xyz, high = texelFetch(cluster_boxes, 2 * int(cluster) + 1).xyz;
  if (any(greaterThan(low, high))) return kRejected;
  if (cull.use_layers && (texelFetch(cluster_layers, int(cluster)).x & cull.view_layers) == 0u) return kRejected;
  if (outside(low, high) || !cluster_selected(low, high)) return kRejected;
  return inside(low, high) ? cluster | kInsideBit : cluster;
}
