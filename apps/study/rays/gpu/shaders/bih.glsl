// BihStack.
#include "query.glsl"
#include "entry.glsl"

struct Node {
  uint bits, a, b;  // Bih::Node
};
layout(std430, binding = 4) readonly restrict buffer Nodes {
  Node nodes[];
};
const uint kMaxDepth = 96u;
Entry stack[kMaxDepth];

void walk() {
  uint size = 0u;
  Entry here = Entry(0u, vec2(0.0, ray_exit));
  for (;;) {
    visit();
    Node n = nodes[here.node];
    uint axis = n.bits & 3u, left = n.bits >> 2;
    if (axis == 3u) {
      if (test(n.a, n.b, -1.0)) return;
    } else {
      bool mirrored = negative(axis);
      float near_end = at(axis, uintBitsToFloat(mirrored ? n.b : n.a));
      float far_begin = at(axis, uintBitsToFloat(mirrored ? n.a : n.b));
      bool enters_near = near_end >= here.t.x, enters_far = far_begin <= here.t.y;
      Entry far = Entry(left + uint(!mirrored), vec2(max(here.t.x, far_begin), here.t.y));
      if (enters_near) {
        if (enters_far) stack[size++] = far;
        here = Entry(left + uint(mirrored), vec2(here.t.x, min(here.t.y, near_end)));
        continue;
      }
      if (enters_far) {
        here = far;
        continue;
      }
    }
    do {
      if (size == 0u) return;
      here = stack[--size];
    } while (here.t.x > nearest);
  }
}
