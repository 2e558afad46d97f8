// One vertex per cluster of 64 neighbouring records: the geometry stage keeps those that are not outside.
#include "cull_test.glsl"

flat out uint kept;
flat out uint name;

void main() {
  uint cluster = uint(gl_VertexID);
  vec3 low = texelFetch(boxes, 2 * gl_VertexID).xyz, high = texelFetch(boxes, 2 * gl_VertexID + 1).xyz;
  kept = present(cluster, low, high) && !outside(low, high) ? 1u : 0u;
  name = cluster | (kept != 0u && inside(low, high) ? kInside : 0u);
}
