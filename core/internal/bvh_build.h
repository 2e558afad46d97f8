// Builds the bounding volume hierarchy that orders a snapshot, top-down over box centroids, in parallel with OpenMP.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/aabb.h"

namespace sightline::core {

/// One node of the binary tree. It spans places first … first + count - 1 of the order. Children lie side by side at
/// `left` and `left + 1` and split that range in two; `left == 0` marks a leaf. Boxes are not kept: whoever traverses
/// the tree keeps them in the form it needs.
struct BvhNode {
  std::uint32_t first = 0, count = 0, left = 0;
  bool leaf() const { return left == 0; }
};

struct BvhTree {
  std::vector<BvhNode> nodes;        ///< nodes[0] is the root; empty for no boxes. Children come after their parent
  std::vector<std::uint32_t> order;  ///< order[place] = index into the boxes given to build_bvh
  std::uint32_t depth = 0;           ///< edges on the longest way down
};

enum class BvhSplit : std::uint8_t {
  /// Across the longest axis, into the largest power of two that leaves something and the rest. Every aligned block of
  /// a power of two of places is a subtree, so a hierarchy over the order needs neither indices nor counts. The order
  /// that cullers take.
  kBlocks,
  /// Binned surface-area heuristic (I. Wald, "On fast construction of SAH-based bounding volume hierarchies", 2007).
  kSurface
};

struct BvhConfig {
  BvhSplit split = BvhSplit::kBlocks;
  std::uint32_t max_leaf_size = 8;  ///< more: fewer nodes, more boxes tested per query
  std::uint32_t bins = 16;          ///< kSurface: more: better splits, slower build (2 … 64)
  int threads = 0;                  ///< 0: all that OpenMP offers. The tree does not depend on it
};

/// Deterministic for given boxes and config. Depth is at most 2 * ceil(log2(count)) + 32 and time O(n log n) on any
/// input: where the heuristic finds no split (coincident centroids) or sinks too deep, ranges are halved. Empty boxes
/// are allowed and gather with the others at the origin. No box may hold a NaN (asserted).
BvhTree build_bvh(std::span<const Aabb> boxes, const BvhConfig& config = {});

}  // namespace sightline::core
