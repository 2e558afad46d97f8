// Meshes as files have them, good and bad, through levels, edits and removal: nothing breaks, memory comes back, and
// what is left shows as in a new engine. Nightly these run with AddressSanitizer.
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/tests/engine/drawn_grid.h"
#include "sightline/tests/lod/mesh_samples.h"

namespace sightline::tests::mesh_edits_test {
namespace {

using engine::CullerChoice;
using engine::Engine;

/// A normal for each face: no two triangles have a vertex in common.
core::Mesh with_face_normals(const core::Mesh& mesh) {
  core::Mesh faces = soup_of(mesh);
  for (std::size_t i = 0; i < faces.positions.size(); i += 3) {
    const core::vec3 normal =
        glm::cross(faces.positions[i + 1] - faces.positions[i], faces.positions[i + 2] - faces.positions[i]);
    faces.normals.insert(faces.normals.end(), 3, normal);
  }
  return faces;
}

/// Some triangles degenerate, some there twice, some at edges of two others.
core::Mesh spoilt(core::Mesh mesh) {
  const std::size_t count = mesh.indices.size();
  const auto apex = std::uint32_t(mesh.positions.size());
  mesh.positions.emplace_back(5.0f, 5.0f, 4.0f);
  for (std::size_t i = 0; i < count; i += 3) {
    const std::uint32_t a = mesh.indices[i], b = mesh.indices[i + 1], c = mesh.indices[i + 2];
    if (i % 7 == 0) mesh.indices.insert(mesh.indices.end(), {a, b, c});
    if (i % 11 == 0) mesh.indices.insert(mesh.indices.end(), {a, b, apex});
    if (i % 13 == 0) mesh.indices[i] = b;
  }
  return mesh;
}

class MeshEdits : public DrawnGrid {
 protected:
  static core::View look(double turn) {
    const core::dvec3 centre(5, 5, 0), eye = centre + 16.0 * core::dvec3(std::cos(turn), std::sin(turn), 0.7);
    return *core::View::perspective({eye, centre, {0, 0, 1}}, 0.7, 1.5, 0.1);
  }
  Engine create(core::Scene& scene, CullerChoice culler, double lod_error) {
    engine::EngineConfig c = config(culler);
    c.losses.lod_error = lod_error;
    auto made = Engine::create(scene, c);
    EXPECT_TRUE(made) << made.error().message;
    return std::move(*made);
  }
  /// Adds it, in portions; moves it; removes it while its details are built, and after that.
  void run(const core::Mesh& mesh, CullerChoice culler, double lod_error) {
    core::Scene scene;
    scene.add_primitive(scene.root(), core::Box{10, 10, 0.1f}, core::translation({5, 5, -3}));
    Engine engine = create(scene, culler, lod_error);
    for (const bool finished : {false, true}) {
      const core::MeshId added = scene.add_mesh(mesh).value();
      const core::ItemId one = scene.add_mesh_instance(scene.root(), added);
      const core::ItemId other = scene.add_mesh_instance(scene.root(), added, core::translation({2, 1, 1}));
      while (!*engine.commit(0.0)) ASSERT_TRUE(engine.frame(look(0.2)));
      if (finished) {
        ASSERT_TRUE(engine.finish_levels());
      }
      ASSERT_TRUE(engine.frame(look(0.4)));
      scene.set_placement(one, core::translation({-1, 0, 1}));
      scene.remove_item(other);
      ASSERT_TRUE(engine.commit() && engine.frame(look(0.6)));
      if (finished) {
        Engine fresh = create(scene, culler, lod_error);
        ASSERT_TRUE(fresh.finish_levels() && fresh.frame(look(0.8)) && engine.frame(look(0.8)));
        ASSERT_NO_FATAL_FAILURE(expect_same_image(engine, fresh, 4));
      }
      scene.remove_item(one);
      scene.remove_mesh(added);
      ASSERT_TRUE(engine.commit() && engine.frame(look(1.0)));
      EXPECT_EQ(engine.memory().levels, 0u);
    }
    ASSERT_TRUE(engine.rebuild() && engine.finish_levels() && engine.frame(look(1.2)));
    EXPECT_EQ(engine.memory().levels, 0u);
  }
};

TEST_F(MeshEdits, OfOrdinaryAndHostileMeshes) {
  std::vector<NamedMesh> meshes = ordinary_meshes();
  for (NamedMesh& named : hostile_meshes(5)) meshes.push_back(std::move(named));
  meshes.push_back({"normals by face", with_face_normals(terrain(40, 1.2))});
  meshes.push_back({"degenerate, doubled and non-manifold faces", spoilt(terrain(40, 1.2))});
  meshes.push_back({"no triangles", {"", {{0, 0, 0}}, {}, {}, {}, {}}});
  auto culler = CullerChoice::kGpu;
  for (const NamedMesh& named : meshes) {
    culler = culler == CullerChoice::kCpu ? CullerChoice::kGpu : CullerChoice::kCpu;
    SCOPED_TRACE(testing::Message() << named.name << ", seed 5, culler " << int(culler));
    ASSERT_NO_FATAL_FAILURE(run(named.mesh, culler, 1.0));
  }
}

/// From 16,384 triangles on there are clusters without an error asked for.
TEST_F(MeshEdits, OfLargeMeshes) {
  const core::Mesh large = terrain(110, 1.3);
  for (const core::Mesh& mesh : {large, with_face_normals(large), soup_of(large), spoilt(large)})
    for (const double error : {0.0, 1.0}) {
      SCOPED_TRACE(testing::Message() << mesh.positions.size() << " vertices, " << error << " px");
      ASSERT_NO_FATAL_FAILURE(run(mesh, CullerChoice::kCpu, error));
    }
}

/// 10^7 triangles: levels are cancelled, and built, and everything comes in portions.
TEST_F(MeshEdits, OfTenMillionTriangles) {
  const core::Mesh huge = terrain(2237, 1.3);
  ASSERT_GE(huge.indices.size(), 30'000'000u);
  ASSERT_NO_FATAL_FAILURE(run(huge, CullerChoice::kCpu, 1.0));
}

}  // namespace
}  // namespace sightline::tests::mesh_edits_test
