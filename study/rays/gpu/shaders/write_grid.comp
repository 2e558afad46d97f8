// From sorted pairs the grid: where each cell begins, and the list of all triangles.
#include "invocation.glsl"

layout(std430, binding = 0) readonly restrict buffer Pairs {
  uvec2 pairs[];  // cell, triangle
};
layout(std430, binding = 1) writeonly restrict buffer Begins {
  uint begins[];  // one more than there are cells
};
layout(std430, binding = 2) writeonly restrict buffer Triangles {
  uint triangles[];
};
layout(location = 1) uniform uint pair_count;
layout(location = 2) uniform uint begin_count;

void main() {
  uint i = invocation();
  if (i < pair_count) triangles[i] = pairs[i].y;
  if (i >= begin_count) return;
  uint low = 0u, high = pair_count;  // the first pair whose cell is not before i
  while (low < high) {
    uint middle = low + (high - low) / 2u;
    if (pairs[middle].x < i)
      low = middle + 1u;
    else
      high = middle;
  }
  begins[i] = low;
}
