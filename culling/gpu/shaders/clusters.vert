// One vertex per cluster of 64 neighbouring records: the geometry stage keeps those that are not outside.
#include "cull_test.glsl"

flat out uint name;

void main() {
  name = test_cluster(uint(gl_VertexID));
}
