// Meshes as files have them, good and bad, through levels, edits and removal: nothing breaks, memory comes back, and
// what is left shows as in a new engine. Nightly these run with AddressSanitizer.
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/engine/pick.h"
#include "sightline/tests/engine/drawing_modes.h"
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

/// Items that get another mesh keep their ids and styles, in every way to draw; also while a portion is late.
TEST_F(MeshEdits, OfItemsThatGetAnotherMesh) {
  using engine::EngineConfig;
  for (const DrawingMode& mode : drawing_modes({
           {"rays",
            [](EngineConfig& c) {
              c.context = {};
              c.drawing.renderer = engine::Renderer::kRays;
            }},
           {"edges", [](EngineConfig& c) { c.drawing.looks.edges.which = engine::EdgeChoice::kFeature; }},
           {"levels", [](EngineConfig& c) { c.losses.lod_error = 1.0; }},
       })) {
    SCOPED_TRACE(mode.name);
    core::Scene scene;
    const core::MeshId coarse = scene.add_mesh(terrain(6, 1.2)).value();
    std::vector<core::ItemId> items;
    for (int i = 0; i < 40; ++i)
      items.push_back(scene.add_mesh_instance(scene.root(), coarse, core::translation({0.3 * i, 0.2 * i, -0.1 * i})));
    EngineConfig c = config(CullerChoice::kAutomatic);
    mode.set(c);
    const auto create = [&] {
      auto made = Engine::create(scene, c);
      const bool styled = made && made->set_override(std::span(items).first(5), {.colour = core::vec3(1, 0, 0)}) &&
                          made->hide(std::span(items).subspan(5, 5)) && made->finish_levels();
      EXPECT_TRUE(styled);
      return made;
    };
    auto engine = create();
    ASSERT_TRUE(engine && engine->frame(look(0.2)));
    const auto expect_as_new = [&](const char* after) {
      SCOPED_TRACE(after);
      auto fresh = create();
      ASSERT_TRUE(fresh && engine->finish_levels());
      for (int frame = 0; frame < 3; ++frame) ASSERT_TRUE(engine->frame(look(0.4)) && fresh->frame(look(0.4)));
      const auto image = engine->read_colour(), wanted = fresh->read_colour();
      ASSERT_TRUE(image && wanted);
      EXPECT_LE(image::compare(*image, *wanted)->max, 4);
      const auto hit = engine->pick(look(0.4), 100, 100), there = fresh->pick(look(0.4), 100, 100);
      ASSERT_TRUE(hit && there && *hit && *there);
      EXPECT_EQ((*hit)->item, (*there)->item);
      EXPECT_EQ(engine->override_of(items[0])->colour, core::vec3(1, 0, 0));
    };
    const core::MeshId fine = scene.add_mesh(terrain(40, 1.2)).value();
    for (std::size_t i = 0; i < items.size(); i += 2) scene.set_mesh(items[i], fine);
    scene.set_visible(items[12], false);
    while (!*engine->commit(0.0)) ASSERT_TRUE(engine->frame(look(0.3)));
    ASSERT_NO_FATAL_FAILURE(expect_as_new("some"));
    for (const core::ItemId item : items) scene.set_mesh(item, fine);
    scene.remove_mesh(coarse);
    ASSERT_TRUE(engine->commit());
    ASSERT_NO_FATAL_FAILURE(expect_as_new("all"));
    ASSERT_TRUE(engine->rebuild());
    ASSERT_NO_FATAL_FAILURE(expect_as_new("another version"));
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
