// KdStandard; with EIGHT_BYTES its other form.
#include "kd_tree.glsl"

struct Entry {
  uint node;
#ifndef EIGHT_BYTES
  float t_min;
#endif
  float t_max;
};
Entry stack[kMaxDepth];
uint size = 0u;

void in_one(uint child) {}
void in_both(uint far, vec2 t) {
#ifdef EIGHT_BYTES
  stack[size++] = Entry(far, t.y);
#else
  stack[size++] = Entry(far, t.x, t.y);
#endif
}
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
#ifdef EIGHT_BYTES
    t = vec2(t.y, entry.t_max);
#else
    t = vec2(entry.t_min, entry.t_max);
#endif
  }
}
