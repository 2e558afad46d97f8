// One vertex per cluster of 64 neighbouring records: the geometry stage keeps those that are not outside.
#include "cull_test.glsl"

flat out uint name;

void main() {
  uint cluster = uint(gl_VertexID);
  vec3 low = texelFetch(boxes, 2 * gl_VertexID).xyz, high = texelFetch(boxes, 2 * gl_VertexID + 1).xyz;
  if (!present(cluster, low, high) || outside(low, high)) name = kRejected;
  else name = inside(low, high) ? cluster | kInside : cluster;
}
