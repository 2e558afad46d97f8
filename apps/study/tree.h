// Binary hierarchies as the study compares them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/aabb.h"

namespace sightline::study {

/// Where a node is split along the longest axis of its box.
enum class Split : std::uint8_t { kMean, kMedian };

/// Node i spans places first … end - 1 of the order. Its left child is i + 1, its right child the left one's escape.
struct TreeNode {
  core::Aabb box;
  std::uint32_t first = 0, end = 0;
  std::uint32_t escape = 0;  ///< next node in depth-first order that is not below this one;
                             ///< the number of nodes for the last
  std::uint32_t depth = 0;   ///< edges from the root
};

struct Tree {
  std::vector<TreeNode> nodes;  ///< depth-first; empty for no boxes
  std::vector<std::uint32_t> order;
  std::uint32_t height = 0;  ///< levels: depth of the deepest node + 1
  std::size_t leaves = 0;
  bool leaf(std::uint32_t i) const { return nodes[i].escape == i + 1; }
};

/// `kinds`: kind of each box (0 … 7), or empty for one kind. A leaf holds at most `leaf_size` boxes of each kind. Where
/// a mean separates nothing the range is halved, hence any input terminates. Iterative. Boxes must not hold NaN and not
/// be empty.
Tree build_tree(std::span<const core::Aabb> boxes, std::span<const std::uint8_t> kinds, Split split,
                std::uint32_t leaf_size = 3);

}  // namespace sightline::study
