// KdHavran.
#include "kd_tree.glsl"
#include "entry.glsl"

Entry stack[kMaxDepth];

void walk() {
  uint size = 0u;
  Entry here = Entry(0u, vec2(0.0, ray_exit));
  for (;;) {
    visit();
    uvec2 n = nodes[here.node];
    if (is_leaf(n)) {
      if (test_leaf(here.node, here.t.y) || size == 0u) return;
      here = stack[--size];
      continue;
    }
    uint axis = axis_of(n);
    bool begins_low = point(axis, here.t.x) <= split_of(n);
    bool ends_low = point(axis, here.t.y) <= split_of(n);
    here.node = left_of(n) + uint(!begins_low);
    if (begins_low == ends_low) continue;
    float split = at(axis, split_of(n));
    stack[size++] = Entry(left_of(n) + uint(begins_low), vec2(split, here.t.y));
    here.t.y = split;
  }
}
