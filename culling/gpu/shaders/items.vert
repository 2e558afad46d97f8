// One vertex per visible cluster, one instance per record in it: the geometry stage keeps the visible ones.
#include "item_test.glsl"

layout(location = 0) in uint cluster;

flat out uint name;

void main() {
  name = test_item(cluster, uint(gl_InstanceID));
}
