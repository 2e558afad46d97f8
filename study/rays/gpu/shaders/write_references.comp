// A pair of cell and triangle for each cell of each box. An invocation a pair: boxes differ in size.
#include "invocation.glsl"
#include "cells_of_box.glsl"

layout(std430, binding = 1) readonly restrict buffer Places {
  uint places[];  // of each box's first pair, rising
};
layout(std430, binding = 2) writeonly restrict buffer Pairs {
  uvec2 pairs[];
};
layout(location = 1) uniform uint box_count;

void main() {
  uint i = invocation();
  if (i >= count) return;
  uint low = 0u, high = box_count;  // the last box that begins at i or before
  while (high - low > 1u) {
    uint middle = low + (high - low) / 2u;
    if (places[middle] <= i)
      low = middle;
    else
      high = middle;
  }
  ivec3 first, last;
  cells_of(low, first, last);
  uvec3 size = uvec3(last - first) + 1u;
  uint within = i - places[low];
  uvec3 c = uvec3(first) + uvec3(within % size.x, within / size.x % size.y, within / (size.x * size.y));
  pairs[i] = uvec2(index_of(ivec3(c)), low);
}
