// One vertex per 64 neighbouring boxes: the planes that these must be tested against.
#include "box_test.glsl"

const uint kClusterOutside = 0xffffffffu;

layout(location = 0) flat out uint planes_left;

void main() {
  vec3 low = texelFetch(boxes, 2 * gl_VertexID).xyz, high = texelFetch(boxes, 2 * gl_VertexID + 1).xyz;
  uint mask = all_planes(), first = 0u;
  planes_left = is_empty(low, high) || outside(low, high, mask, first) ? kClusterOutside : remaining(low, high, mask);
}
