// BvhStack.
#include "query.glsl"
#include "box.glsl"

struct Node {
  Box box;
  uint first, count;
};
layout(std430, binding = 4) readonly restrict buffer Nodes {
  Node nodes[];
};
const uint kMaxDepth = 96u;
uint stack[kMaxDepth];

// Parameter where the ray enters the box at or before `limit`; infinity for nowhere.
float entry_of(Box box, float limit) {
  precise vec3 a = (low_of(box) - ray.unit_origin.xyz) * ray.unit_inverse.xyz;
  precise vec3 b = (high_of(box) - ray.unit_origin.xyz) * ray.unit_inverse.xyz;
  vec3 low = min(a, b), high = max(a, b);
  float entry = max(max(low.x, low.y), max(low.z, 0.0));
  return entry <= min(min(high.x, high.y), min(high.z, limit)) ? entry : uintBitsToFloat(0x7f800000u);
}

void walk() {
  uint size = 0u, index = 0u;
  for (;;) {
    visit();
    uint first = nodes[index].first, count = nodes[index].count;
    if (count != 0u) {
      if (test(first, count, -1.0)) return;
    } else {
      float limit = min(ray_exit, nearest);
      float left = entry_of(nodes[first].box, limit), right = entry_of(nodes[first + 1u].box, limit);
      bool right_first = right < left, enters_left = !isinf(left), enters_right = !isinf(right);
      if (enters_left && enters_right) stack[size++] = first + uint(!right_first);
      if (enters_left || enters_right) {
        index = first + uint(right_first);
        continue;
      }
    }
    if (size == 0u) return;
    index = stack[--size];
  }
}
