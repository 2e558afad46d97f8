// GridLines.
#include "space.glsl"

float line(uint axis, int i) {
  precise float position = space.low[axis] + float(i) * space.cell[axis];
  return position;
}

int cell_of(uint axis, float position) {
  precise float cell = (position - space.low[axis]) * space.per_cell[axis];
  return int(clamp(cell, 0.0, float(space.cells[axis] - 1)));
}

uint index_of(ivec3 c) { return (uint(c.z) * uint(space.cells.y) + uint(c.y)) * uint(space.cells.x) + uint(c.x); }
