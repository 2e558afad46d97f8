// A block is kClustersPerBlock clusters. A work group handles one block at a time, with one invocation for each record
// of a cluster. C++ side: culling/gpu/compute_pass.cpp.
#include "cull_limits.glsl"

layout(local_size_x = kItemsPerCluster) in;

layout(std430, binding = 0) restrict buffer Masks {
  uint masks[];  // per block and place in a cluster: bit c is the visibility of that record of the block's cluster c
};
layout(std430, binding = 1) restrict buffer Places {
  uint places[];  // per batch, place in a cluster and block: number of bits, then how many records precede in the batch
};
// Clusters, blocks, blocks before these, blocks of batches before this one. Blocks of parts follow those of the records.
layout(location = 0) uniform uvec4 batch;

uint mask_index(uint block, uint i) {
  return (batch.z + block) * gl_WorkGroupSize.x + i;
}

uint place_index(uint block, uint i) {
  return batch.z * gl_WorkGroupSize.x + i * batch.y + block;
}
