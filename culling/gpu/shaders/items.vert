// One vertex per visible cluster, one instance per record or part in it: the geometry stage keeps the visible ones.
#include "tested.glsl"

layout(location = 0) in uint cluster;

layout(location = 0) flat out uint name;
#ifdef COUNTS_IN_VIEW
layout(location = 1) flat out uint counted;
#endif

void main() {
  bool in_view;
  name = keep(cluster, uint(gl_InstanceID), in_view);
#ifdef COUNTS_IN_VIEW
  counted = in_view ? 1u : 0u;
#endif
}
