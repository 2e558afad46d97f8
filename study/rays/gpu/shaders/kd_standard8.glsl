// KdStandard8.
#include "kd_tree.glsl"

struct Entry {
  uint node;
  float t_max;
};
Entry stack[kMaxDepth];
uint size = 0u;

void in_one(uint child) {}
void in_both(uint far, vec2 t) { stack[size++] = Entry(far, t.y); }
#include "kd_descend.glsl"

void walk() {
  size = 0u;
  uint node = 0u;
  vec2 t = vec2(0.0, ray_exit);
  for (;;) {
    uint leaf = descend(node, t);
    if (test_leaf(leaf, t.y) || size == 0u) return;
    Entry entry = stack[--size];
    node = entry.node;
    t = vec2(t.y, entry.t_max);
  }
}
