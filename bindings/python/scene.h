// A scene and what Python holds of it: handles that keep the scene alive and notice when their object is gone.
#pragma once

#include <memory>
#include <optional>
#include <unordered_map>

#include "sightline/bindings/python/convert.h"
#include "sightline/bindings/python/gate.h"
#include "sightline/core/scene.h"

namespace sightline::python {

struct SceneBox {
  core::Scene scene;
  Gate gate;
  std::unordered_map<std::uint32_t, int> mesh_views;  ///< arrays that look into a mesh, by its index

  const core::Scene& read() {
    gate.pass(Use::kRead);
    return scene;
  }
  core::Scene& edit() {
    gate.pass(Use::kWrite);
    return scene;
  }
};
using ScenePtr = std::shared_ptr<SceneBox>;

/// An object of a scene: the scene lives as long as this. Equal handles are equal in Python, too.
template <class Id>
struct Of {
  ScenePtr scene;
  Id id;
  friend bool operator==(const Of&, const Of&) = default;
};
using Node = Of<core::NodeId>;
using Mesh = Of<core::MeshId>;
using Material = Of<core::MaterialId>;
struct Item : Of<core::ItemId> {};

/// The scene to read or edit. Fails when the object has been removed.
template <class Handle>
const core::Scene& read(const Handle& handle);
template <class Handle>
core::Scene& edit(const Handle& handle);

using SceneClass = py::class_<SceneBox, ScenePtr>;
void bind_import(py::module_& m, SceneClass& scene);

/// The id of a node of `scene`; of its root for None. Fails for another scene's node and for a removed one.
core::NodeId node_in(const ScenePtr& scene, const std::optional<Node>& node, const char* argument);

}  // namespace sightline::python
