// Binary hierarchies by the binned surface-area heuristic (I. Wald, "On fast construction of SAH-based bounding volume
// hierarchies", 2007).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/aabb.h"

namespace sightline::study {

/// Spans places first … first + count - 1 of the order. Children lie side by side at `left` and `left + 1` and split
/// that range in two; `left == 0` marks a leaf.
struct SahNode {
  std::uint32_t first = 0, count = 0, left = 0;
  bool leaf() const { return left == 0; }
};

struct SahTree {
  std::vector<SahNode> nodes;        ///< nodes[0] is the root; empty for no boxes. Children come after their parent
  std::vector<std::uint32_t> order;  ///< order[place] = index into the boxes
  std::uint32_t depth = 0;           ///< edges on the longest way down
};

struct SahConfig {
  std::uint32_t max_leaf_size = 8;  ///< more: fewer nodes, more boxes tested per query
  std::uint32_t bins = 16;          ///< more: better splits, slower build (2 … 64)
  std::uint32_t group = 8;          ///< boxes tested at a time: the cost of a leaf counts groups
};

/// Deterministic. Depth is at most 2 * ceil(log2(count)) + 32 and time O(n log n) on any input: where the heuristic
/// finds no split (coincident centroids) or sinks too deep, ranges are halved. Empty boxes are allowed and gather with
/// the others at the origin. No box may hold a NaN.
SahTree build_sah(std::span<const core::Aabb> boxes, const SahConfig& config = {});

}  // namespace sightline::study
