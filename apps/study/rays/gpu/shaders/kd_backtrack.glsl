// KdBacktrack.
#include "kd_tree.glsl"
#include "box_exit.glsl"

layout(std430, binding = 5) readonly restrict buffer Parents {
  uint parents[];
};
layout(std430, binding = 6) readonly restrict buffer Boxes {
  Box boxes[];  // of the nodes
};

void in_one(uint child) {}
void in_both(uint far, vec2 t) {}
#include "kd_descend.glsl"

void walk() {
  uint node = 0u;
  vec2 t = vec2(0.0, ray_exit);
  for (;;) {
    node = descend(node, t);
    if (test_leaf(node, t.y) || t.y >= ray_exit) return;
    t.x = t.y;
    while (node != 0u && t.y <= t.x) {
      visit();
      node = parents[node];
      uint axis;
      t.y = min(ray_exit, exit_of(boxes[node], axis));
    }
    if (node == 0u) t.y = ray_exit;
  }
}
