// The nodes of a revision in flat arrays. Internal.
#pragma once

#include <cstdint>
#include <vector>

#include "sightline/analysis/compare/compare.h"

namespace sightline::compare {

/// Nodes are named by their position in tree order, 0 being the top, and items by theirs.
struct Tree {
  explicit Tree(const Revision& revision);

  /// The highest node from `node` upwards for which `holds`, which must hold for `node` and, where it does not hold,
  /// neither for the nodes above. O(log n) calls.
  template <class Holds>
  std::uint32_t climb(std::uint32_t node, const Holds& holds) const {
    while (node != 0) {
      if (holds(jump[node]))
        node = jump[node];
      else if (holds(parent[node]))
        node = parent[node];
      else
        break;
    }
    return node;
  }
  /// The lowest node that has both below it, or is one of them; a <= b.
  std::uint32_t common(std::uint32_t a, std::uint32_t b) const {
    if (end[a] > b) return a;
    return parent[climb(a, [&](std::uint32_t node) { return end[node] <= b; })];
  }

  std::vector<core::NodeId> nodes;
  std::vector<std::uint32_t> parent;      // the top is its own
  std::vector<std::uint32_t> jump;        // an ancestor further up, so that paths to all others are short
  std::vector<std::uint32_t> depth, end;  // the subtree ends before `end`
  std::vector<std::uint32_t> first_item;  // of the subtree, whose items are in one range; one more for the end
  std::vector<core::ItemId> items;
  std::vector<std::uint32_t> node_of_item;
};

}  // namespace sightline::compare
