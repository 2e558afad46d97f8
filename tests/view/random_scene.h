// Scenes of random trees, for tests of the viewer's panels.
#pragma once

#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include "sightline/core/scene.h"

namespace sightline::tests {

using Random = std::mt19937_64;

/// The nodes of a scene, parents first, in their order.
inline std::vector<core::NodeId> nodes_of(const core::Scene& scene) {
  std::vector<core::NodeId> nodes;
  scene.for_each_node(scene.root(), [&](core::NodeId node, const core::Affine&, bool, std::uint32_t, core::MaterialId) {
    nodes.push_back(node);
  });
  return nodes;
}

/// Adds `count` nodes, each below a random one, and items to some of them. One tree in three is deep, one is wide.
inline void grow(core::Scene& scene, Random& random, std::size_t count) {
  std::vector<core::NodeId> nodes = nodes_of(scene);
  const auto shape = random() % 3;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t last = nodes.size() - 1;
    const std::size_t parent = shape == 0   ? last - std::min<std::size_t>(last, random() % 3)
                               : shape == 1 ? random() % std::min<std::size_t>(nodes.size(), 4)
                                            : random() % nodes.size();
    nodes.push_back(scene.add_node(nodes[parent]));
    for (auto items = random() % 4; items > 1; --items) scene.add_primitive(nodes.back(), core::Box{1, 1, 1});
  }
}

}  // namespace sightline::tests
