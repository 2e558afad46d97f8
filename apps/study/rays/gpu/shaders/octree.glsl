// OctreeRevelles. The recursion is a stack of the nodes from the root to the one that the ray is in.
#include "query.glsl"

layout(std430, binding = 4) readonly restrict buffer Nodes {
  uvec2 nodes[];  // first, count; of inner nodes the count is kNone
};
const uint kMaxDepth = 17u;

struct Level {
  vec3 low, high;  // parameters where the ray meets the node's planes
  uint first, octant;
};
Level levels[kMaxDepth];

vec3 middle_of(vec3 low, vec3 high) {
  precise vec3 middle = 0.5 * (low + high);
  return middle;
}

void walk() {
  vec3 low, high;
  uint mirror = 0u;
  for (uint a = 0u; a < 3u; ++a) {
    bool mirrored = negative(a);
    low[a] = at(a, mirrored ? space.high[a] : space.low[a]);
    high[a] = at(a, mirrored ? space.low[a] : space.high[a]);
    mirror |= uint(mirrored) << a;
  }
  float entry = 0.0;
  uint node = 0u, depth = 0u;
  for (;;) {
    visit();
    uvec2 n = nodes[node];
    if (n.y == kNone) {
      vec3 middle = middle_of(low, high);
      uint octant = 0u;
      for (uint a = 0u; a < 3u; ++a) octant |= uint(middle[a] <= entry) << a;
      levels[depth++] = Level(low, high, n.x, octant);
    } else {
      float exit = min(min(high.x, high.y), high.z);
      entry = max(entry, exit);
      if (test(n.x, n.y, exit) || entry >= ray_exit) return;
      for (;; --depth) {  // to the next octant of the deepest node that has one
        if (depth == 0u) return;
        Level level = levels[depth - 1u];
        vec3 middle = middle_of(level.low, level.high), child_high;
        for (uint a = 0u; a < 3u; ++a) child_high[a] = (level.octant >> a & 1u) != 0u ? level.high[a] : middle[a];
        uint x_or_y = child_high.x <= child_high.y ? 0u : 1u;
        uint axis = child_high[x_or_y] <= child_high.z ? x_or_y : 2u;
        if ((level.octant >> axis & 1u) != 0u) continue;
        levels[depth - 1u].octant = level.octant | 1u << axis;
        break;
      }
    }
    Level level = levels[depth - 1u];
    vec3 middle = middle_of(level.low, level.high);
    for (uint a = 0u; a < 3u; ++a) {
      bool upper = (level.octant >> a & 1u) != 0u;
      low[a] = upper ? middle[a] : level.low[a];
      high[a] = upper ? level.high[a] : middle[a];
    }
    node = level.first + (level.octant ^ mirror);
  }
}
