// Adds to each value the sum of all blocks before its own.
#include "invocation.glsl"

layout(std430, binding = 0) restrict buffer Values {
  uint values[];
};
layout(std430, binding = 1) readonly restrict buffer Sums {
  uint sums[];
};
layout(location = 1) uniform uint block_size;

void main() {
  uint i = invocation();
  if (i < count) values[i] += sums[i / block_size];
}
