// KdNode.
#include "query.glsl"

layout(std430, binding = 4) readonly restrict buffer Nodes {
  uvec2 nodes[];
};
const uint kMaxDepth = 60u;

bool is_leaf(uvec2 n) { return (n.y & 3u) == 3u; }
uint axis_of(uvec2 n) { return n.y & 3u; }
uint left_of(uvec2 n) { return n.y >> 2; }
float split_of(uvec2 n) { return uintBitsToFloat(n.x); }

bool test_leaf(uint node, float exit) {
  uvec2 n = nodes[node];
  return test(n.x, n.y >> 2, exit);
}
