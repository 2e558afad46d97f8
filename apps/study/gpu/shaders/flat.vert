// One vertex per box. Its answer goes to the geometry stage, which drops what is outside, or with SIGNED straight out.
#include "box_test.glsl"

#ifdef SIGNED
layout(location = 0) flat out int answer;  // number of the box from 1 on; negative: outside
#else
layout(location = 0) flat out uint name;
const uint kRejected = 0xffffffffu;  // what keep.geom drops
#endif

void main() {
  vec3 low = texelFetch(boxes, 2 * gl_VertexID).xyz, high = texelFetch(boxes, 2 * gl_VertexID + 1).xyz;
  bool gone = outside(low, high);
#ifdef SIGNED
  answer = gone ? -gl_VertexID - 1 : gl_VertexID + 1;
#else
  name = gone ? kRejected : uint(gl_VertexID);
#endif
}
