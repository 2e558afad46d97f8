// A pass of a radix sort: four bits of the cell. An invocation has a run of pairs, which it goes through in order, so
// that the sort is stable and triangles stay in order within a cell.
#include "invocation.glsl"

const uint kRun = 64u, kDigits = 16u;

layout(std430, binding = 0) readonly restrict buffer Pairs {
  uvec2 pairs[];  // cell, triangle
};
layout(std430, binding = 1) restrict buffer Places {
  uint places[];  // by digit, and then by run
};
layout(location = 1) uniform uint pair_count;
layout(location = 2) uniform uint shift;

uint digit_of(uint cell) { return cell >> shift & (kDigits - 1u); }
