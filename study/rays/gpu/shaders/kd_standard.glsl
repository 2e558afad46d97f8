// KdStandard.
#include "kd_tree.glsl"
#include "entry.glsl"

Entry stack[kMaxDepth];
uint size = 0u;

void in_one(uint child) {}
void in_both(uint far, vec2 t) { stack[size++] = Entry(far, t); }
#include "kd_descend.glsl"

void walk() {
  size = 0u;
  Entry here = Entry(0u, vec2(0.0, ray_exit));
  for (;;) {
    uint leaf = descend(here.node, here.t);
    if (test_leaf(leaf, here.t.y) || size == 0u) return;
    here = stack[--size];
  }
}
