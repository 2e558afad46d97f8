// One vertex per visible cluster, one instance per record in it: the geometry stage keeps the visible ones.
#include "cull_test.glsl"

layout(location = 0) in uint cluster;

flat out uint name;

void main() {
  name = (cluster & ~kInside) * kItemsPerCluster + uint(gl_InstanceID);
  int place = 2 * int(name);
  vec3 low = texelFetch(boxes, place).xyz, high = texelFetch(boxes, place + 1).xyz;
  if (!present(name, low, high) || ((cluster & kInside) == 0u && outside(low, high))) name = kRejected;
}
