// KdRestart; with PUSH_DOWN KdPushDown.
#include "kd_tree.glsl"

uint root = 0u;
bool whole = false;  // all of the ray that remains lies in the node

void in_one(uint child) {
#ifdef PUSH_DOWN
  if (whole) root = child;
#endif
}
void in_both(uint far, vec2 t) { whole = false; }
#include "kd_descend.glsl"

void walk() {
  root = 0u;
  vec2 t = vec2(0.0, ray_exit);
  for (;;) {
    whole = true;
    uint leaf = descend(root, t);
    if (test_leaf(leaf, t.y) || t.y >= ray_exit) return;
    t = vec2(t.y, ray_exit);
  }
}
