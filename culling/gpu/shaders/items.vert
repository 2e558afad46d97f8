// One vertex per visible cluster, one instance per record in it: the geometry stage keeps the visible ones.
#include "item_test.glsl"

layout(location = 0) in uint cluster;

flat out uint name;
#ifdef COUNTS_IN_VIEW
flat out uint counted;
#endif

void main() {
  bool in_view;
  name = test_item(cluster, uint(gl_InstanceID), in_view);
#ifdef COUNTS_IN_VIEW
  counted = in_view ? 1u : 0u;
#endif
}
