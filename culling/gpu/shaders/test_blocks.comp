// Finds the visible records of one batch: one work group per block.
#include "blocks.glsl"
#include "item_test.glsl"

shared uint tested[kClustersPerBlock];

#ifdef COUNTS_IN_VIEW
layout(std430, binding = 4) restrict buffer Results {
  uint results[];  // per probe: items in the view volume, items written
};
layout(location = 2) uniform uint result;

shared uint in_view_count;
#endif

void main() {
  uint block = gl_WorkGroupID.x, i = gl_LocalInvocationIndex;
  if (i < kClustersPerBlock) {
    uint cluster = block * kClustersPerBlock + i;
    tested[i] = cluster < batch.x ? test_cluster(cluster) : kRejected;
  }
#ifdef COUNTS_IN_VIEW
  if (i == 0u) in_view_count = 0u;
#endif
  barrier();
  uint mask = 0u, count = 0u;
  for (uint c = 0u; c < kClustersPerBlock; ++c) {
    if (tested[c] == kRejected) continue;
    bool in_view;
    if (test_item(tested[c], i, in_view) != kRejected) mask |= 1u << c;
    if (in_view) ++count;
  }
#ifdef COUNTS_IN_VIEW
  atomicAdd(in_view_count, count);
  barrier();
  if (i == 0u) atomicAdd(results[2u * result], in_view_count);
#endif
  masks[mask_index(block, i)] = mask;
  places[place_index(block, i)] = uint(bitCount(mask));
}
