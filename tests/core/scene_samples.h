// A pipe and a triangle for scenes, and what hangs below a node as lists.
#pragma once

#include <vector>

#include "sightline/core/primitive.h"
#include "sightline/core/scene.h"

namespace sightline::tests {

inline const core::Primitive kPipe = core::Cylinder{1.0f, 2.0f};

using Ids = std::vector<core::ItemId>;

inline Ids items_of(const core::Scene& scene, core::NodeId node) {
  Ids ids;
  for (core::ItemId i = scene.first_item(node); i != core::kNoItem; i = scene.next_item(i)) ids.push_back(i);
  return ids;
}

inline std::vector<core::NodeId> children_of(const core::Scene& scene, core::NodeId node) {
  std::vector<core::NodeId> children;
  for (core::NodeId c = scene.first_child(node); c.valid(); c = scene.next_sibling(c)) children.push_back(c);
  return children;
}

inline core::Mesh triangle() {
  core::Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.indices = {0, 1, 2};
  return mesh;
}

}  // namespace sightline::tests
