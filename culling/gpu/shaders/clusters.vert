// One vertex per cluster of 64 neighbouring records, or of parts of meshes: the geometry stage keeps those that are not
// outside.
#include "tested.glsl"

layout(location = 0) flat out uint name;

void main() {
  name = keep_cluster(uint(gl_VertexID));
}
