// Finds the visible records of one batch, or parts of their meshes: one work group per block.
#include "blocks.glsl"
#include "tested.glsl"

shared uint tested[kClustersPerBlock];

#ifdef PARTS
layout(binding = 4) uniform usamplerBuffer commands;  // where of_parts is 0

// Records whose parts are drawn have a command without indices.
bool drawn_by_parts(uint record) {
  return of_parts == 0 && texelFetch(commands, int(COMMAND_WORDS * record)).x == 0u;
}
#endif

#if defined(COUNTS_IN_VIEW) || defined(PARTS)
layout(std430, binding = 4) restrict buffer Results {
  uint results[];  // per probe: items in the view volume, items written
};
layout(location = 2) uniform uint result;

shared uint in_view_count, apart_count;  // apart: selected, but drawn by parts
#endif

void main() {
  uint block = gl_WorkGroupID.x, i = gl_LocalInvocationIndex;
  if (i < kClustersPerBlock) {
    uint cluster = block * kClustersPerBlock + i;
    tested[i] = cluster < batch.x ? keep_cluster(cluster) : kRejected;
  }
#if defined(COUNTS_IN_VIEW) || defined(PARTS)
  if (i == 0u) in_view_count = apart_count = 0u;
#endif
  barrier();
  uint mask = 0u, count = 0u, apart = 0u;
  for (uint c = 0u; c < kClustersPerBlock; ++c) {
    if (tested[c] == kRejected) continue;
    bool in_view;
    uint name = keep(tested[c], i, in_view);
    if (in_view) ++count;
    if (name == kRejected) continue;
#ifdef PARTS
    if (drawn_by_parts(name)) {
      ++apart;
      continue;
    }
#endif
    mask |= 1u << c;
  }
#if defined(COUNTS_IN_VIEW) || defined(PARTS)
  atomicAdd(in_view_count, count);
  atomicAdd(apart_count, apart);
  barrier();
  if (i == 0u) {
    atomicAdd(results[2u * result], in_view_count);
    atomicAdd(results[2u * result + 1u], apart_count);
  }
#endif
  masks[mask_index(block, i)] = mask;
  places[place_index(block, i)] = uint(bitCount(mask));
}
