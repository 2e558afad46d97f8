// SbgWalk.
#include "query.glsl"
#include "grid_lines.glsl"

struct SparseBox {
  uint low_xy, low_z_high_x, high_yz;  // cells, 16 bits each
  uint first, count;
};
layout(std430, binding = 4) readonly restrict buffer Boxes {
  SparseBox boxes[];
};
layout(std430, binding = 5) readonly restrict buffer BoxOfCell {
  uint box_of_cell[];
};

void walk() {
  ivec3 cell;
  for (uint a = 0u; a < 3u; ++a) cell[a] = cell_of(a, ray.unit_origin[a]);
  for (;;) {
    visit();
    SparseBox box = boxes[box_of_cell[index_of(cell)]];
    ivec3 low = ivec3(box.low_xy & 0xffffu, box.low_xy >> 16, box.low_z_high_x & 0xffffu);
    ivec3 high = ivec3(box.low_z_high_x >> 16, box.high_yz & 0xffffu, box.high_yz >> 16);
    float exit = 0.0;
    uint axis = 3u;
    for (uint a = 0u; a < 3u; ++a) {
      float t = at(a, line(a, negative(a) ? low[a] : high[a]));
      if (axis == 3u || t < exit) {
        exit = t;
        axis = a;
      }
    }
    if (test(box.first, box.count, exit) || exit >= ray_exit) return;
    for (uint a = 0u; a < 3u; ++a) {
      if (a == axis)
        cell[a] = negative(a) ? low[a] - 1 : high[a];
      else
        cell[a] = clamp(cell_of(a, point(a, exit)), negative(a) ? low[a] : cell[a], negative(a) ? cell[a] : high[a] - 1);
    }
    if (cell[axis] < 0 || cell[axis] >= space.cells[axis]) return;
  }
}
