// How many items lie below each node of a tree, and how many of them show. No window.
#pragma once

#include <cstdint>
#include <vector>

#include "sightline/apps/view/document.h"
#include "sightline/apps/view/tree_rows.h"

namespace sightline::apps {

class TreeStates {
 public:
  struct Below {
    std::uint32_t items = 0, shown = 0;

    bool hidden() const { return items > 0 && shown == 0; }
    bool partly_hidden() const { return shown > 0 && shown < items; }
  };

  /// Counts anew, in a step an item, if rows, items or what is hidden have changed since the last call.
  void follow(const TreeRows& rows, const core::Scene& scene, const Document& document);
  /// What lies below a node, the node's own items included; nothing for nodes that the rows do not contain.
  Below below(const TreeRows& rows, core::NodeId node) const;

 private:
  std::uint64_t resets_ = 0, version_ = ~std::uint64_t{0};  // those of the last count
  std::size_t items_ = 0;
  std::vector<Below> before_;  // by place of the tree: sums of all places before; one more at the end
};

}  // namespace sightline::apps
