// Search for nodes by name and attributes.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "sightline/core/api.h"
#include "sightline/core/scene.h"

namespace sightline::core {

/// A condition on a node's name or attributes. ASCII letters match regardless of case, all other bytes exactly.
struct NodeCondition {
  std::string key;   ///< empty: the node's name or the value of any attribute; else the value of that attribute
  std::string text;  ///< must occur in it; empty matches any value
};

/// The nodes of the subtree that fulfil all conditions, parents first. Looks at every node, name and attribute: some
/// 50 ns each.
SIGHTLINE_API std::vector<NodeId> find_nodes(const Scene& scene, NodeId top, std::span<const NodeCondition> conditions);

}  // namespace sightline::core
