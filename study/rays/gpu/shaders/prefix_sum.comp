// Replaces each value by the sum of those before it in its group's block, and writes the sum of each block.
#include "invocation.glsl"

const uint kRun = 8u;  // values of an invocation

layout(std430, binding = 0) restrict buffer Values {
  uint values[];
};
layout(std430, binding = 1) writeonly restrict buffer Sums {
  uint sums[];
};
shared uint sum_to[gl_WorkGroupSize.x];

void main() {
  uint i = gl_LocalInvocationIndex, begin = min(invocation() * kRun, count), end = min(begin + kRun, count), sum = 0u;
  for (uint k = begin; k < end; ++k) sum += values[k];
  sum_to[i] = sum;
  barrier();
  for (uint reach = 1u; reach < gl_WorkGroupSize.x; reach *= 2u) {
    uint before = i >= reach ? sum_to[i - reach] : 0u;
    barrier();
    sum_to[i] += before;
    barrier();
  }
  uint place = sum_to[i] - sum;
  for (uint k = begin; k < end; ++k) {
    uint value = values[k];
    values[k] = place;
    place += value;
  }
  if (i == gl_WorkGroupSize.x - 1u && group() * gl_WorkGroupSize.x * kRun < count) sums[group()] = place;
}
