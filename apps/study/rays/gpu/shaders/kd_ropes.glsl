// KdRopes; with SIX_PLANES Popov's form; with FROM_ROOT KdSequential.
#include "kd_tree.glsl"
#include "box_exit.glsl"

struct Leaf {
  Box box;
  uint ropes[6];
  uint first, count;
};
layout(std430, binding = 5) readonly restrict buffer Leaves {
  Leaf leaves[];
};

// Front::descend(): to the leaf that has the point. The loop ends as in kd_descend.glsl.
uint descend(uint node, vec3 p) {
  visit();
  uvec2 n = nodes[node];
  while (!is_leaf(n)) {
    uint axis = axis_of(n);
    float split = split_of(n);
    bool low = p[axis] < split || (p[axis] == split && negative(axis));
    n = nodes[left_of(n) + uint(!low)];
    visit();
  }
  return n.x;
}

float entry_of(Box box) {
  vec3 low = low_of(box), high = high_of(box);
  float t = 0.0;
  for (uint a = 0u; a < 3u; ++a) t = max(t, at(a, negative(a) ? high[a] : low[a]));
  return t;
}

void walk() {
  uint node = 0u;
  vec3 front = ray.unit_origin.xyz;
  for (;;) {
    uint leaf = descend(node, front);
    Box box = leaves[leaf].box;
    uint axis;
    float exit = exit_of(box, axis);
#ifdef SIX_PLANES
    exit = max(exit, entry_of(box));
#endif
    if (test(leaves[leaf].first, leaves[leaf].count, exit) || exit >= ray_exit) return;
    uint rope = leaves[leaf].ropes[axis + (negative(axis) ? 0u : 3u)];
    if (rope == kNone) return;
#ifndef FROM_ROOT
    node = rope;
#endif
    vec3 low = low_of(box), high = high_of(box);
    for (uint a = 0u; a < 3u; ++a) front[a] = clamp(point(a, exit), low[a], high[a]);
    front[axis] = negative(axis) ? low[axis] : high[axis];
  }
}
