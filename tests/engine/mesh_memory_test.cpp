// What engines report of memory while meshes come and go, and what one portion of a commit or of a frame does: bytes
// and counts, never times.
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/engine/internal/engine_parts.h"
#include "sightline/lod/mesh_levels.h"
#include "sightline/tests/engine/drawn_grid.h"
#include "sightline/tests/lod/mesh_samples.h"
#include "sightline/tests/support/effort.h"

namespace sightline::tests::mesh_memory_test {
namespace {

using engine::CullerChoice;
using engine::Engine;

class MeshMemory : public DrawnGrid {
 protected:
  static constexpr std::uint32_t kLarge = 120;  // cells a side: 28,800 triangles

  static core::View look(double turn) {
    const core::dvec3 centre(6, 5, 0), eye = centre + 18.0 * core::dvec3(std::cos(turn), std::sin(turn), 0.7);
    return *core::View::perspective({eye, centre, {0, 0, 1}}, 0.8, 1.5, 0.1);
  }

  struct Placed {
    core::MeshId mesh;
    core::ItemId item;
  };
  static Placed add(core::Scene& scene, core::Mesh shape, double x = 0.0) {
    Placed placed;
    placed.mesh = scene.add_mesh(std::move(shape)).value();
    placed.item = scene.add_mesh_instance(scene.root(), placed.mesh, core::translation({x, 0.0, 0.0}));
    return placed;
  }
  static void remove(core::Scene& scene, const Placed& placed) {
    scene.remove_item(placed.item);
    scene.remove_mesh(placed.mesh);
  }
  Engine create(core::Scene& scene, double lod_error, CullerChoice culler = CullerChoice::kCpu) {
    engine::EngineConfig c = config(culler);
    c.losses.lod_error = lod_error;
    auto made = Engine::create(scene, c);
    EXPECT_TRUE(made) << made.error().message;
    return std::move(*made);
  }
  static std::uint64_t done(Engine& engine) {
    return engine::EngineParts::drawing(engine)->scene().meshes().elements_done();
  }
};

TEST_F(MeshMemory, ComesBackWithEachRemoval) {
  const core::Mesh shape = terrain(kLarge, 1.2);
  ASSERT_GT(shape.indices.size(), 3 * lod::kLargeMesh);
  for (const auto culler : {CullerChoice::kCpu, CullerChoice::kGpu})
    for (const double error : {0.0, 1.0}) {
      SCOPED_TRACE(testing::Message() << "culler " << int(culler) << ", " << error << " px");
      core::Scene scene;
      scene.add_primitive(scene.root(), core::Box{1, 1, 1});
      Engine engine = create(scene, error, culler);
      ASSERT_TRUE(engine.frame(look(0.3)));
      const engine::MemoryReport empty = engine.memory();
      std::size_t most = 0;
      const int rounds = culler == CullerChoice::kCpu ? 24 : 8;
      for (int round = 0; round < rounds; ++round) {
        SCOPED_TRACE(round);
        const Placed placed = add(scene, shape);
        ASSERT_TRUE(engine.commit() && engine.frame(look(0.3)));
        // Some are removed before their levels are built, some after that, and some between.
        if (round % 8 == 3) {
          ASSERT_TRUE(engine.finish_levels());
        }
        if (round % 2 == 0) {
          ASSERT_TRUE(engine.frame(look(0.4)));
        }
        most = std::max(most, engine.memory().gpu);
        remove(scene, placed);
        ASSERT_TRUE(engine.commit());
        EXPECT_EQ(engine.memory().levels, 0u);
        // The GPU culler keeps room for as many clusters as there were.
        EXPECT_LE(engine.memory().gpu, empty.gpu + (culler == CullerChoice::kCpu ? 1u << 19 : 1u << 22))
            << "of " << most << " with the mesh";
      }
      ASSERT_TRUE(engine.finish_levels());
      EXPECT_EQ(engine.memory().levels, 0u) << "none are built of removed meshes";
    }
}

/// As many meshes live at any time as before, and so do their levels.
TEST_F(MeshMemory, FollowsTheMeshesThatLive) {
  core::Scene scene;
  Engine engine = create(scene, 1.0);
  std::vector<Placed> live;
  std::size_t levels = 0, gpu = 0;
  for (int round = 0; round < repeated(600); ++round) {
    live.push_back(add(scene, terrain(40 + std::uint32_t(round % 5), 1.2), 3.0 * (round % 10)));
    if (live.size() > 10) {
      remove(scene, live.front());
      live.erase(live.begin());
    }
    ASSERT_TRUE(round % 3 == 0 ? bool(engine.commit(0.0)) : bool(engine.commit()));
    ASSERT_TRUE(engine.frame(look(0.01 * round)));
    if (round % 10 != 9) continue;
    ASSERT_TRUE(engine.commit() && engine.finish_levels());
    if (round < 20) levels = engine.memory().levels, gpu = engine.memory().gpu;
    EXPECT_LE(engine.memory().levels, levels + levels / 4) << round;
    EXPECT_LE(engine.memory().gpu, gpu + gpu / 2) << round;
  }
}

/// Levels that nobody asks for any more go, too.
TEST_F(MeshMemory, IsThatOfANewEngineAfterARebuild) {
  core::Scene scene;
  add(scene, terrain(30, 1.2));
  std::vector<Placed> gone;
  for (int i = 0; i < 8; ++i) gone.push_back(add(scene, terrain(120, 1.2), i));
  Engine engine = create(scene, 1.0);
  ASSERT_TRUE(engine.finish_levels() && engine.frame(look(0.3)));
  for (const Placed& placed : gone) remove(scene, placed);
  engine::EngineConfig c = engine.config();
  c.losses.lod_error = 0.0;
  ASSERT_TRUE(engine.configure(c) && engine.rebuild());
  Engine fresh = create(scene, 0.0);
  for (Engine* each : {&engine, &fresh}) ASSERT_TRUE(each->finish_levels() && each->frame(look(0.3)));
  EXPECT_EQ(engine.memory().levels, fresh.memory().levels);
  EXPECT_EQ(engine.memory().gpu, fresh.memory().gpu);
  ASSERT_NO_FATAL_FAILURE(expect_same_image(engine, fresh, 1));
}

/// What is left shows as in a new engine after the buffers have shrunk, by any culler, and grows again.
TEST_F(MeshMemory, ShrinksWithoutLosingAnything) {
  for (const auto& [culler, error] : {std::pair(CullerChoice::kCpu, 0.0),
                                      {CullerChoice::kCpu, 2.0},
                                      {CullerChoice::kGpu, 2.0},
                                      {CullerChoice::kHybrid, 0.0}}) {
    SCOPED_TRACE(testing::Message() << "culler " << int(culler) << ", " << error << " px");
    core::Scene scene;
    std::vector<Placed> all;
    for (int i = 0; i < 24; ++i)
      all.push_back(
          add(scene, i % 2 ? bumpy_torus(std::uint32_t(20 + i), 0.1) : terrain(std::uint32_t(30 + 4 * i), 1.2), i % 8));
    scene.add_mesh_instance(scene.root(), all[7].mesh, core::translation({5, 5, 5}));
    Engine engine = create(scene, error, culler);
    ASSERT_TRUE(engine.finish_levels() && engine.frame(look(0.3)));
    const auto& pool = engine::EngineParts::drawing(engine)->scene().meshes();
    std::size_t before = pool.memory_bytes();
    for (std::size_t i = 0; i < all.size(); ++i)
      if (i % 5 != 2) {
        scene.remove_item(all[i].item);
        if (i != 7) scene.remove_mesh(all[i].mesh);
      }
    while (!*engine.commit(0.0)) ASSERT_TRUE(engine.frame(look(0.4)));
    for (int i = 0; i < 60 && pool.memory_bytes() > before / 2; ++i) ASSERT_TRUE(engine.frame(look(0.4)));
    EXPECT_LT(pool.memory_bytes(), before / 2);
    const auto compare = [&, culler = culler, error = error] {
      Engine fresh = create(scene, error, culler);
      ASSERT_TRUE(fresh.finish_levels() && engine.finish_levels());
      ASSERT_TRUE(engine.frame(look(0.5)) && fresh.frame(look(0.5)));
      ASSERT_NO_FATAL_FAILURE(expect_same_image(engine, fresh, 1));
    };
    ASSERT_NO_FATAL_FAILURE(compare());
    add(scene, terrain(150, 1.2), 9.0);
    add(scene, bumpy_torus(50, 0.1), 6.0);
    ASSERT_TRUE(engine.commit() && engine.frame(look(0.3)));
    ASSERT_NO_FATAL_FAILURE(compare());
  }
}

/// Each portion uploads about as much as the next: vertices, indices, and what moves where buffers grow.
TEST_F(MeshMemory, MeshesComeInPortions) {
  constexpr std::uint64_t kMost = 600'000;  // elements of a portion, of which moves are a whole piece
  core::Scene scene;
  add(scene, terrain(20, 1.2));
  Engine engine = create(scene, 0.0);
  ASSERT_TRUE(engine.frame(look(0.3)));
  for (int i = 0; i < 3; ++i) add(scene, terrain(316, 1.2), i);  // of 200,000 triangles
  int portions = 0;
  for (bool all = false; !all; ++portions) {
    ASSERT_LT(portions, 1000);
    const std::uint64_t before = done(engine);
    const auto committed = engine.commit(0.0);
    ASSERT_TRUE(committed);
    all = *committed;
    EXPECT_LE(done(engine) - before, kMost) << "portion " << portions;
  }
  EXPECT_GE(portions, 20);
  // Nothing is drawn of a mesh that is not there; then all is, and levels and clusters come in portions, too.
  Engine fresh = create(scene, 0.0);
  ASSERT_TRUE(engine.frame(look(0.3)) && fresh.frame(look(0.3)));
  ASSERT_NO_FATAL_FAILURE(expect_same_image(engine, fresh, 1));
  ASSERT_TRUE(engine.finish_levels() && fresh.finish_levels() && engine.frame(look(0.3)) && fresh.frame(look(0.3)));
  ASSERT_NO_FATAL_FAILURE(expect_same_image(engine, fresh, 1));
}

/// Items that come and go in one portion are as many as a piece has, whoever publishes them.
TEST_F(MeshMemory, ItemsComeInPortions) {
  core::Scene scene;
  add(scene, terrain(20, 1.2));
  Engine engine = create(scene, 0.0);
  const std::size_t before = engine.snapshot().size();
  const core::NodeId node = scene.add_node(scene.root());
  for (int i = 0; i < 20'000; ++i)
    scene.add_primitive(i % 4 ? node : scene.root(), core::Cylinder{0.1f, 1.0f}, core::translation({0.01 * i, 1, 0}));
  std::size_t slots = before, portions = 0;
  for (bool all = false; !all; ++portions) {
    const auto committed = engine.commit(0.0);
    ASSERT_TRUE(committed);
    all = *committed;
    EXPECT_LE(engine.snapshot().size() - slots, 512u);
    slots = engine.snapshot().size();
  }
  EXPECT_EQ(slots, before + 20'000);
  EXPECT_GE(portions, 40u);
  // Everything below a node moves, and a commit of the whole may come between.
  scene.set_transform(node, core::translation({0, 0, 3}));
  ASSERT_TRUE(engine.commit(0.0));
  scene.set_transform(scene.root(), core::translation({0, 2, 0}));
  ASSERT_TRUE(engine.commit(0.0));
  ASSERT_TRUE(scene.commit());
  while (!*engine.commit(0.0)) continue;
  Engine fresh = create(scene, 0.0);
  ASSERT_TRUE(engine.frame(look(0.3)) && fresh.frame(look(0.3)));
  const auto difference = image::compare(*engine.read_colour(), *fresh.read_colour());
  ASSERT_TRUE(difference);
  EXPECT_LE(difference->pixels, 20u) << "of other orders";
}

}  // namespace
}  // namespace sightline::tests::mesh_memory_test
