// A scene whose cache has many pages.
#pragma once

#include "sightline/core/scene.h"
#include "sightline/tests/lod/mesh_samples.h"

namespace sightline::tests {

/// Tori in rows, each a mesh of its own among boxes. Meshes take so many bytes that a page has some hundred items: by
/// vertices that no triangle uses, which cost little time.
inline core::Scene scene_of_many_pages(int items) {
  core::Scene scene;
  const core::NodeId node = scene.add_node(scene.root(), "tori");
  const core::MaterialId red = scene.add_material({"red", {0.8f, 0.1f, 0.1f}});
  for (int i = 0; i < items; ++i) {
    core::Affine place = core::translation({9.0 * (i % 25), 9.0 * (i / 25), i % 7 * 0.5});
    if (i % 3 == 0) place.linear = core::dmat3(0, 1, 0, -1, 0, 0, 0, 0, 1.5);
    if (i % 8 == 7) {
      scene.add_primitive(node, core::Box{4.0f, 4.0f, 1.0f}, place);
      continue;
    }
    core::Mesh torus = bumpy_torus(i % 2 ? 14 : 9, 0.02 + 0.0001 * i);
    torus.positions.resize(torus.positions.size() + 7000, core::vec3(0.0f));
    scene.add_mesh_instance(node, *scene.add_mesh(std::move(torus)), place, i % 5 ? core::MaterialId() : red);
  }
  return scene;
}

}  // namespace sightline::tests
