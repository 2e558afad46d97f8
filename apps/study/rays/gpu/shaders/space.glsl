// The numbers that describe a structure besides its arrays.
layout(std140, binding = 0) uniform Space {  // SpaceBlock of structures.cpp
  vec4 low, high;       // of the structure's bounds
  vec4 cell, per_cell;  // GridLines, of those that have some
  ivec4 cells;
  double slack;  // on boxes of triangles, in units of the scene
} space;
