// One vertex per box. Its answer goes to the geometry stage, which drops what is outside, or with SIGNED straight out.
#include "box_test.glsl"

#ifdef SIGNED
layout(location = 0) flat out int answer;  // number of the box from 1 on; negative: outside
#else
layout(location = 0) flat out uint name;
const uint kRejected = 0xffffffffu;  // what keep.geom drops
const uint kWhole = 0x80000000u;     // with SPLIT: the box lies wholly inside
#endif

#ifdef MASKING
layout(binding = 5) uniform usamplerBuffer masks;  // of each cluster, from flat_clusters.vert
const int kBoxesPerCluster = 64;
const uint kClusterOutside = 0xffffffffu;
#endif

#ifdef PLANE_ORDER
layout(std430, binding = 0) restrict buffer PlaneOrder { uint first_planes[]; };  // per box: the last to reject it
#endif

bool box_outside(inout uint mask) {
  vec3 low = texelFetch(boxes, 2 * gl_VertexID).xyz, high = texelFetch(boxes, 2 * gl_VertexID + 1).xyz;
  if (is_empty(low, high)) return true;
  uint first = 0u;
#ifdef PLANE_ORDER
  first = first_planes[gl_VertexID];
  uint before = first;
#endif
  bool result = outside(low, high, mask, first);
#ifdef PLANE_ORDER
  if (first != before) first_planes[gl_VertexID] = first;
#endif
  return result;
}

void main() {
  uint mask = all_planes();
#ifdef MASKING
  mask = texelFetch(masks, gl_VertexID / kBoxesPerCluster).x;
  bool gone = mask == kClusterOutside || box_outside(mask);
#else
  bool gone = box_outside(mask);
#endif
#ifdef SIGNED
  answer = gone ? -gl_VertexID - 1 : gl_VertexID + 1;
#else
  name = gone ? kRejected : uint(gl_VertexID);
#ifdef SPLIT
  if (!gone && mask == 0u) name |= kWhole;
#endif
#endif
}
