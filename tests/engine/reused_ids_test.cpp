// Picks of items whose ids others have had: Scene::reuse_ids().
#include <algorithm>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/engine/engine.h"
#include "sightline/engine/pick.h"
#include "sightline/gpuprims/internal/primitives.h"
#include "sightline/tests/support/effort.h"

namespace sightline::tests::reused_ids_test {
namespace {

using engine::Engine;

/// Items come and go, half of them with a mesh that goes with them.
class Traffic {
 public:
  Traffic() {
    scene.reuse_ids(true);
    for (int i = 0; i < 600; ++i) add();
  }
  void exchange(int count) {
    for (int i = 0; i < count; ++i) remove();
    for (int i = 0; i < count; ++i) add();
  }
  core::dvec3 somewhere() {
    std::uniform_real_distribution<double> place(0.0, 12.0);
    const double x = place(random), y = place(random);
    return {x, y, place(random)};
  }

  core::Scene scene;
  std::vector<core::ItemId> items;
  std::mt19937 random{5};

 private:
  void add() {
    if (nodes_.size() < 40) nodes_.push_back(scene.add_node(scene.root()));
    const core::NodeId node = nodes_[random() % nodes_.size()];
    const core::Affine at = core::translation(somewhere());
    const int sides = 3 + int(random() % 9);
    if (random() % 2) {
      const auto mesh = scene.add_mesh(gpuprims::tessellate(core::Sphere{0.9f}, {.fixed_segments = sides})).value();
      items.push_back(scene.add_mesh_instance(node, mesh, at));
    } else if (sides % 2) {
      items.push_back(scene.add_primitive(node, core::Sphere{0.1f * float(sides)}, at));
    } else {
      items.push_back(scene.add_primitive(node, core::Box{0.1f * float(sides), 0.5f, 0.5f}, at));
    }
  }
  void remove() {
    std::swap(items[random() % items.size()], items.back());
    const core::ItemId item = items.back();
    items.pop_back();
    const bool has_mesh = int(scene.kind(item)) >= core::kPrimitiveKindCount;
    const core::MeshId mesh = has_mesh ? scene.mesh_of(item) : core::MeshId();
    scene.remove_item(item);
    if (has_mesh) scene.remove_mesh(mesh);
  }
  std::vector<core::NodeId> nodes_;
};

void expect_same_picks(Traffic& traffic, Engine& a, Engine& b) {
  for (const core::ItemId item : traffic.items) {
    const core::dvec3 from = traffic.somewhere(), to = traffic.scene.placement(item).origin + 0.05;
    const auto x = a.pick({from, glm::normalize(to - from)}), y = b.pick({from, glm::normalize(to - from)});
    ASSERT_TRUE(x && y);
    ASSERT_EQ(x->has_value(), y->has_value());
    if (!*x) continue;
    ASSERT_EQ((*x)->item, (*y)->item);
    ASSERT_EQ((*x)->node, traffic.scene.node_of((*x)->item));
    ASSERT_NEAR((*x)->t, (*y)->t, 1e-4);
  }
}

/// `share`: EngineConfig::culling.rebuild_share.
void expect_picks_of_an_engine_made_anew(double share) {
  SCOPED_TRACE("seed 5");
  Traffic traffic;
  auto followed = Engine::create(traffic.scene, {.culling = {.rebuild_share = share}});
  ASSERT_TRUE(followed && followed->pick({core::dvec3(0.0), {1, 0, 0}}));
  int swaps = 0;
  for (int round = 0; round < 60; ++round) {
    const std::uint64_t order = followed->snapshot().generation();
    for (int piece = 0; piece < 8; ++piece) {  // commits that a new scene version comes to know at once
      traffic.exchange(12);
      ASSERT_TRUE(piece % 2 == 1 || followed->commit());
      while (!*followed->commit(0.0)) continue;
    }
    ASSERT_TRUE(round % 17 != 16 || followed->rebuild());
    swaps += followed->snapshot().generation() != order;
    if (round % 4 != 3) continue;
    auto anew = Engine::create(traffic.scene);
    ASSERT_TRUE(anew);
    ASSERT_NO_FATAL_FAILURE(expect_same_picks(traffic, *followed, *anew)) << "round " << round;
  }
  EXPECT_GE(swaps, share > 0.0 ? 4 : 3) << "three by rebuild(); how many in the background depends on its thread";
  EXPECT_LT(traffic.scene.item_slots(), 800u) << "5,760 were added";
  EXPECT_LT(traffic.scene.mesh_slots(), 500u);
}

TEST(ReusedIds, PicksAfterEdits) {
  ASSERT_NO_FATAL_FAILURE(expect_picks_of_an_engine_made_anew(0.0));
}
TEST(ReusedIds, PicksAcrossNewVersions) {
  ASSERT_NO_FATAL_FAILURE(expect_picks_of_an_engine_made_anew(0.05));
}

/// Everything that an engine has, over ten million items in a long run. It is counted in orders just made, since how
/// much one in the background holds, and how much room is left in one that took edits, depend on when its thread ran.
TEST(ReusedIds, AnEngineTakesAsMuchMemoryAfterMillionsOfItems) {
  Traffic traffic;
  auto engine = Engine::create(traffic.scene, {.culling = {.culler = engine::CullerChoice::kCpu}});
  ASSERT_TRUE(engine);
  std::size_t settled = 0, most = 0;
  for (int commit = 0; commit < (tests::long_run() ? 20'000 : 600); ++commit) {
    traffic.exchange(500);
    ASSERT_TRUE(engine->commit());
    if (commit % 10 != 9) continue;
    ASSERT_TRUE(engine->rebuild());
    const engine::MemoryReport memory = engine->memory();
    (commit < 300 ? settled : most) =
        std::max(commit < 300 ? settled : most, memory.scene + memory.snapshot + memory.bvh);
  }
  EXPECT_LE(double(most), 1.25 * double(settled));
}

}  // namespace
}  // namespace sightline::tests::reused_ids_test
