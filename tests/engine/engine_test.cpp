// The engine without drawing: plans, frames, edits and errors.
#include "sightline/engine/engine.h"

#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace sightline::engine {
namespace {

using core::dvec3;
using core::View;

/// Boxes on a grid, n^3 of them, one metre apart.
void add_grid(core::Scene& scene, int n) {
  for (int i = 0; i < n * n * n; ++i)
    scene.add_primitive(scene.root(), core::Box{0.4f, 0.4f, 0.4f}, core::translation({i % n, i / n % n, i / n / n}));
}

View look(const dvec3& eye, const dvec3& target) {
  return *View::perspective({eye, target, {0, 0, 1}}, 0.8, 1.5, 0.1);
}

std::vector<core::ItemId> visible_items(const Engine& engine) {
  std::vector<core::ItemId> items;
  for (const core::Slot slot : engine.visible().sorted_slots())
    if (!engine.snapshot().vacant(slot)) items.push_back(engine.snapshot().item(slot));
  EXPECT_EQ(items.size(), engine.snapshot().count(engine.visible()));
  std::sort(items.begin(), items.end());
  return items;
}

TEST(Engine, SmallScenesGetNoHierarchy) {
  core::Scene small, large;
  add_grid(small, 4);
  add_grid(large, 8);
  auto a = Engine::create(small), b = Engine::create(large);
  ASSERT_TRUE(a && b);
  EXPECT_STREQ(a->culler_name(), "linear");
  EXPECT_STREQ(b->culler_name(), "cpu");
  EXPECT_GT(b->memory().bvh, a->memory().bvh);
  auto forced = Engine::create(small, {.culler = CullerChoice::kCpu});
  ASSERT_TRUE(forced);
  EXPECT_STREQ(forced->culler_name(), "cpu");
}

TEST(Engine, EveryPlanEntryHasAReason) {
  core::Scene scene;
  add_grid(scene, 3);
  auto engine = Engine::create(scene);
  ASSERT_TRUE(engine);
  for (const PlanEntry& e : engine->plan().entries) EXPECT_FALSE(e.why.empty()) << e.feature;
}

TEST(Engine, BothCullersSeeTheSameThroughRandomEdits) {
  core::Scene scene;
  add_grid(scene, 9);
  auto linear = Engine::create(scene, {.culler = CullerChoice::kLinear});
  ASSERT_TRUE(linear);
  std::mt19937 random{7};
  for (int round = 0; round < 20; ++round) {
    SCOPED_TRACE(round);
    auto edited = Engine::create(scene, {.culler = CullerChoice::kCpu});
    ASSERT_TRUE(edited);
    for (int i = 0; i < 30; ++i) {
      const core::ItemId item = core::ItemId(random() % scene.item_slots());
      if (!scene.contains_item(item)) continue;
      const dvec3 place(random() % 12, random() % 12, random() % 12);
      switch (random() % 4) {
        case 0:
          scene.set_placement(item, core::translation(place));
          break;
        case 1:
          scene.set_visible(item, random() % 2 == 0);
          break;
        case 2:
          scene.remove_item(item);
          break;
        default:
          scene.add_primitive(scene.root(), core::Sphere{1}, core::translation(place));
      }
    }
    ASSERT_TRUE(edited->commit());
    auto fresh = Engine::create(scene, {.culler = CullerChoice::kLinear});
    ASSERT_TRUE(fresh);
    for (const View& view : {look({-5, 4, 4}, {4, 4, 4}), look({4, 4, 4}, {8, 5, 3}), look({40, 40, 40}, {0, 0, 0})}) {
      ASSERT_TRUE(edited->frame(view) && fresh->frame(view));
      EXPECT_EQ(visible_items(*edited), visible_items(*fresh));
    }
    ASSERT_TRUE(edited->rebuild());
    ASSERT_TRUE(edited->frame(look({-5, 4, 4}, {4, 4, 4})) && fresh->frame(look({-5, 4, 4}, {4, 4, 4})));
    EXPECT_EQ(visible_items(*edited), visible_items(*fresh));
  }
}

TEST(Engine, ABadSceneIsAnErrorThatNamesTheNode) {
  core::Scene scene;
  const core::NodeId node = scene.add_node(scene.root(), "pump");
  scene.add_primitive(node, core::Sphere{1}, core::translation({std::numeric_limits<double>::quiet_NaN(), 0, 0}));
  const auto engine = Engine::create(scene);
  ASSERT_FALSE(engine);
  EXPECT_NE(engine.error().message.find("pump"), std::string::npos);
}

TEST(Engine, FramesCountWhatTheyDid) {
  core::Scene scene;
  add_grid(scene, 8);
  auto engine = Engine::create(scene);
  ASSERT_TRUE(engine);
  const auto all = engine->frame(look({-30, 4, 4}, {4, 4, 4}));
  ASSERT_TRUE(all);
  EXPECT_EQ(all->visible, 512u);
  EXPECT_GT(all->tested, 0u);
  EXPECT_LT(all->tested, 512u);
  EXPECT_EQ(all->frame_ms, 0.0);
  const auto none = engine->frame(look({-30, 4, 4}, {-40, 4, 4}));
  ASSERT_TRUE(none);
  EXPECT_EQ(none->visible, 0u);
  EXPECT_GT(none->frame_ms, 0.0);
}

}  // namespace
}  // namespace sightline::engine
