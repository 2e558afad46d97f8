// GridDda.
#include "query.glsl"
#include "grid_lines.glsl"

layout(std430, binding = 4) readonly restrict buffer Begins {
  uint begins[];  // of each cell in triangles[], and their end
};

void walk() {
  ivec3 cell;
  vec3 next;
  for (uint a = 0u; a < 3u; ++a) {
    cell[a] = cell_of(a, ray.unit_origin[a]);
    next[a] = at(a, line(a, cell[a] + int(!negative(a))));
  }
  for (;;) {
    visit();
    uint x_or_y = next.x <= next.y ? 0u : 1u;
    uint axis = next[x_or_y] <= next.z ? x_or_y : 2u;
    uint i = index_of(cell), begin = begins[i];
    if (test(begin, begins[i + 1u] - begin, next[axis]) || next[axis] >= ray_exit) return;
    cell[axis] += negative(axis) ? -1 : 1;
    if (cell[axis] < 0 || cell[axis] >= space.cells[axis]) return;
    next[axis] = at(axis, line(axis, cell[axis] + int(!negative(axis))));
  }
}
