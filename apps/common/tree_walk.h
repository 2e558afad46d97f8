// Visits the nodes of a scene in tree order, which has parents before their children and these in their order, and
// lists what lies below a node.
#pragma once

#include <vector>

#include "sightline/core/internal/sort_unique.h"
#include "sightline/core/scene.h"

namespace sightline::apps {

/// Calls enter(node) for each node in tree order, and leave(node) after its last descendant. Nesting may be as deep as
/// memory allows.
template <class Enter, class Leave>
void walk(const core::Scene& scene, Enter&& enter, Leave&& leave) {
  core::NodeId node = scene.root();
  for (;;) {
    enter(node);
    if (const core::NodeId child = scene.first_child(node); child.valid()) {
      node = child;
      continue;
    }
    core::NodeId next;
    while (node.valid() && !(next = scene.next_sibling(node)).valid()) {
      leave(node);
      node = scene.parent(node);
    }
    if (!node.valid()) return;
    leave(node);
    node = next;
  }
}

inline std::vector<core::NodeId> children_of(const core::Scene& scene, core::NodeId node) {
  std::vector<core::NodeId> children;
  for (core::NodeId child = scene.first_child(node); child.valid(); child = scene.next_sibling(child))
    children.push_back(child);
  return children;
}

/// The items of nodes and of all nodes below them, in rising order.
inline std::vector<core::ItemId> items_below(const core::Scene& scene, const std::vector<core::NodeId>& nodes) {
  std::vector<core::ItemId> items;
  for (const core::NodeId node : nodes)
    scene.for_each_node(node, [&](core::NodeId below, const auto&...) {
      for (core::ItemId item = scene.first_item(below); item != core::kNoItem; item = scene.next_item(item))
        items.push_back(item);
    });
  core::sort_unique(items);
  return items;
}
inline std::vector<core::ItemId> items_below(const core::Scene& scene, core::NodeId node) {
  return items_below(scene, std::vector<core::NodeId>{node});
}

}  // namespace sightline::apps
