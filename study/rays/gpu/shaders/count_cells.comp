// The number of cells of each box.
#include "invocation.glsl"
#include "cells_of_box.glsl"

layout(std430, binding = 1) writeonly restrict buffer Counts {
  uint counts[];
};

void main() {
  uint i = invocation();
  if (i >= count) return;
  ivec3 first, last;
  cells_of(i, first, last);
  uvec3 size = uvec3(last - first) + 1u;
  counts[i] = size.x * size.y * size.z;
}
