// KdShortStack; with PUSH_DOWN its other form.
#include "kd_tree.glsl"
#include "entry.glsl"

const uint kEntries = 5u;
Entry stack[kEntries];
uint top = 0u, size = 0u, root = 0u;
bool whole = false;

void in_one(uint child) {
  if (whole) root = child;
}
void in_both(uint far, vec2 t) {
  whole = false;
  stack[top] = Entry(far, t);
  top = (top + 1u) % kEntries;
  size = min(size + 1u, kEntries);
}
#include "kd_descend.glsl"

#ifdef PUSH_DOWN
const bool kPushDown = true;
#else
const bool kPushDown = false;
#endif

void walk() {
  top = size = root = 0u;
  whole = kPushDown;
  Entry here = Entry(0u, vec2(0.0, ray_exit));
  for (;;) {
    uint leaf = descend(here.node, here.t);
    if (test_leaf(leaf, here.t.y) || here.t.y >= ray_exit) return;
    whole = kPushDown && size == 0u;
    if (size == 0u) {
      here = Entry(root, vec2(here.t.y, ray_exit));
    } else {
      --size;
      top = (top + kEntries - 1u) % kEntries;
      here = stack[top];
    }
  }
}
