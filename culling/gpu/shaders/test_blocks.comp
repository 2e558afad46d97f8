// Finds the visible records of one batch: one work group per block.
#include "blocks.glsl"
#include "item_test.glsl"

shared uint tested[kClustersPerBlock];

void main() {
  uint block = gl_WorkGroupID.x, i = gl_LocalInvocationIndex;
  if (i < kClustersPerBlock) {
    uint cluster = block * kClustersPerBlock + i;
    tested[i] = cluster < batch.x ? test_cluster(cluster) : kRejected;
  }
  barrier();
  uint mask = 0u;
  for (uint c = 0u; c < kClustersPerBlock; ++c)
    if (tested[c] != kRejected && test_item(tested[c], i) != kRejected) mask |= 1u << c;
  masks[mask_index(block, i)] = mask;
  places[place_index(block, i)] = uint(bitCount(mask));
}
