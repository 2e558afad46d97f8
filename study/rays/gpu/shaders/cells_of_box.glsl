// The boxes of the triangles, and the cells that each overlaps.
#include "box.glsl"
#include "grid_lines.glsl"

layout(std430, binding = 0) readonly restrict buffer Boxes {
  Box boxes[];
};

void cells_of(uint box, out ivec3 first, out ivec3 last) {
  vec3 low = low_of(boxes[box]), high = high_of(boxes[box]);
  for (uint a = 0u; a < 3u; ++a) {
    first[a] = cell_of(a, low[a]);
    last[a] = cell_of(a, high[a]);
  }
}
