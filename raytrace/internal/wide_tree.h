// Builds a wide hierarchy over boxes: binned surface area heuristic, top down, the largest child first until a node has
// eight. (I. Wald, "On fast construction of SAH-based bounding volume hierarchies", 2007.)
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "sightline/core/aabb.h"
#include "sightline/core/large_array.h"
#include "sightline/raytrace/internal/wide_node.h"

namespace sightline::raytrace {

/// A box and what it is of.
struct alignas(16) BoxRef {
  float low[3];
  std::uint32_t id;
  float high[3];
  std::uint32_t unused = 0;
};

struct LeafRange {
  std::uint32_t first, count;  ///< in BuiltTree::refs
};

struct BuiltTree {
  core::LargeArray<WideNode> nodes;  ///< the first is the root; none when the root is a leaf or nothing
  std::vector<LeafRange> leaves;     ///< children with kLeafBit count these
};

/// Orders `refs` so that each leaf is a range of at most `largest_leaf` (1 or more). No box may be empty or hold
/// anything that is not finite. The tree does not depend on the number of `threads`; 0: all that OpenMP offers.
/// `spare_nodes`: that `nodes` has room for besides its own. Once `stop` was requested it ends within milliseconds, and
/// the result says nothing.
BuiltTree build_wide_tree(std::span<BoxRef> refs, std::uint32_t largest_leaf, int threads, std::size_t spare_nodes = 0,
                          const std::stop_token& stop = {});

/// Whether to look for a stop after so many steps of a loop, some nanoseconds each.
constexpr bool looks_for_stop(std::size_t step) {
  return step % 32768 == 0;
}

}  // namespace sightline::raytrace
