// A small scene with one of everything, its scene cache in memory, and changes to that.
#pragma once

#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/core/mesh_extras.h"
#include "sightline/importers/slc/slc_writer.h"
#include "sightline/tests/importers/many_pages.h"
#include "sightline/tests/importers/slc_seal.h"
#include "sightline/tests/lod/mesh_samples.h"

namespace sightline::tests {

inline core::Mesh triangle(float size, bool facets = false) {
  core::Mesh mesh;
  mesh.name = "triangle";
  mesh.positions = {{0, 0, 0}, {size, 0, 0}, {0, size, 0}};
  mesh.indices = {0, 1, 2};
  if (facets) {
    mesh.contour_sizes = {3};
    mesh.polygon_contours = {1};
  } else {
    mesh.normals.assign(3, {0, 0, 1});
  }
  return mesh;
}

/// All kinds, shared meshes, materials, layers, attributes, what is hidden, what was removed, far from the origin.
inline core::Scene scene_with_everything() {
  using namespace core;
  core::Scene scene;
  const NodeId file = scene.add_node(scene.root(), "plant.rvm", translation({1e7, -1e7 / 3.0, 123.456}));
  const MaterialId red = scene.add_material({"red", {1, 0, 0}, 1.0f, 7});
  const MaterialId gone = scene.add_material({"gone", {0, 1, 0}, 1.0f, 8});
  const MaterialId glass = scene.add_material({"gl\xff", {0, 0, 1}, 0.25f, 9});
  const MeshId shared = *scene.add_mesh(triangle(1.0f));
  const MeshId unused = *scene.add_mesh(triangle(2.0f));
  const MeshId facets = *scene.add_mesh(triangle(3.0f, true));
  const MeshId empty = *scene.add_mesh({});
  std::vector<NodeId> nodes{file};
  const Primitive solids[] = {Pyramid{1, 2, 3, 4, 0.1f, 0.2f, 5},
                              Box{1, 2, 3},
                              RectangularTorus{1, 2, 0.5f, 1.5f},
                              CircularTorus{2, 0.5f, 3},
                              EllipticalDish{1, 0.5f},
                              SphericalDish{1, 0.25f},
                              Snout{1, 0.5f, 2, 0.1f, 0.2f, 0.05f, 0.0f, 0.1f, 0.0f},
                              Cylinder{0.5f, 3},
                              Sphere{2},
                              Line{-1, 2}};
  for (int i = 0; i < 90; ++i) {
    const NodeId parent = nodes[std::size_t(i * 7) % nodes.size()];
    Affine place = translation({i * 1.5, i % 7 * 2.25, -i * 0.125});
    place.linear[0][1] = i % 3 * 0.25;
    const NodeId node = scene.add_node(parent, i % 5 == 0 ? "" : "node \xe2\x82\xac " + std::to_string(i), place);
    nodes.push_back(node);
    scene.add_primitive(node, solids[i % 10], translation({0.0, i * 0.3, 0.0}), i % 4 == 0 ? glass : MaterialId{});
    if (i % 6 == 0) scene.add_mesh_instance(node, i % 12 == 0 ? shared : facets, {}, red);
    if (i % 30 == 0) scene.add_mesh_instance(node, empty);
    if (i % 8 == 0) scene.set_attribute(node, "Tag", "P-" + std::to_string(i));
    if (i % 16 == 0) scene.set_attribute(node, "", std::string("a\0b", 3));
    if (i % 9 == 0) scene.set_layers(node, kLayerInsulation);
    if (i % 11 == 0) scene.set_visible(node, false);
    if (i % 13 == 0) scene.set_material(node, red);
  }
  scene.set_visible(ItemId(3), false);
  scene.remove_item(core::ItemId{5});
  scene.remove_node(nodes[40]);
  scene.remove_node(nodes[80]);
  scene.add_node(file, "takes the place of one that was removed");
  scene.remove_mesh(unused);
  scene.remove_material(gone);
  return scene;
}

/// Meshes with levels of detail among others.
inline core::Scene scene_with_levels() {
  core::Scene scene = scene_with_everything();
  const core::NodeId node = scene.add_node(scene.root(), "surfaces");
  for (const std::uint32_t cells : {12u, 20u}) {
    const core::MeshId torus = *scene.add_mesh(bumpy_torus(cells, 0.1));
    for (int i = 0; i < 3; ++i) scene.add_mesh_instance(node, torus, core::translation({9.0 * i, double(cells), 0.0}));
  }
  return scene;
}

/// A mesh of two faces with surfaces among others without.
inline core::Scene scene_with_surfaces() {
  core::Scene scene = scene_with_everything();
  core::Mesh mesh = triangle(2.0f);
  mesh.indices = {0, 1, 2, 0, 2, 1};
  std::vector<core::MeshSurface> surfaces(2);
  surfaces[0].kind = core::MeshSurface::Kind::kPlane, surfaces[0].end_triangle = 1;
  surfaces[1].kind = core::MeshSurface::Kind::kTorus, surfaces[1].end_triangle = 2;
  surfaces[1].origin = {1, 2, 3}, surfaces[1].radius = 4, surfaces[1].tube_radius = 0.5, surfaces[1].gap = 1e-3;
  mesh.extras = core::MeshExtrasSlot({nullptr, std::make_shared<const std::vector<core::MeshSurface>>(surfaces)});
  const core::MeshId id = *scene.add_mesh(std::move(mesh));
  const core::NodeId node = scene.add_node(scene.root(), "surfaces");
  for (int i = 0; i < 2; ++i) scene.add_mesh_instance(node, id, core::translation({9.0 * i, 0.0, 0.0}));
  return scene;
}

inline std::vector<std::byte> bytes_of_file(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

inline void write_bytes(const std::filesystem::path& file, std::span<const std::byte> bytes) {
  std::ofstream out(file, std::ios::binary | std::ios::trunc);
  out.write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
}

inline std::vector<std::byte> slc_of(const core::Scene& scene, bool levels = false) {
  const auto file = std::filesystem::path(testing::TempDir()) /
                    ("sightline-slc-" + std::to_string(reinterpret_cast<std::uintptr_t>(&scene)) + ".slc");
  const auto done = importers::write_slc(scene, file, {.levels = levels});
  EXPECT_TRUE(done) << (done ? "" : done.error().message);
  auto bytes = bytes_of_file(file);
  std::filesystem::remove(file);
  return bytes;
}

}  // namespace sightline::tests
