// Visits the nodes of a scene in tree order: parents before their children, children in their order.
#pragma once

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

}  // namespace sightline::apps
