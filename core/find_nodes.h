// Nodes by what they are called and what is known of them.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "sightline/core/scene.h"

namespace sightline::core {

/// ASCII letters compare without case; all other bytes as they are.
struct NodeCondition {
  std::string key;   ///< empty: the node's name or the value of any attribute; else the value of that attribute
  std::string text;  ///< is part of it; empty fits any value
};

/// The nodes of the subtree that fulfil all conditions, parents first. Looks at every node, name and attribute: some
/// 50 ns each.
std::vector<NodeId> find_nodes(const Scene& scene, NodeId top, std::span<const NodeCondition> conditions);

}  // namespace sightline::core
