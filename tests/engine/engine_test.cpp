// The engine without drawing: plans, frames, edits and errors.
#include "sightline/engine/engine.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <random>
#include <thread>

#include <gtest/gtest.h>

#include "sightline/engine/internal/rebuild.h"

namespace sightline::engine::engine_test {
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

View look_at_all() {
  return look({90, 90, 90}, {0, 0, 0});
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
  EXPECT_EQ(name_of(a->plan().culler), "linear");
  EXPECT_EQ(name_of(b->plan().culler), "cpu");
  EXPECT_GT(b->memory().bvh, a->memory().bvh);
  auto forced = Engine::create(small, {.culling = {.culler = CullerChoice::kCpu}});
  ASSERT_TRUE(forced);
  EXPECT_EQ(name_of(forced->plan().culler), "cpu");
}

/// A culler on the GPU tests occlusion in large scenes alone, and one on the CPU in smaller ones, too.
TEST(Engine, PlansSayWhereOcclusionIsTested) {
  const auto entry_of = [](const core::Snapshot& snapshot, CullerChoice culler, OcclusionChoice occlusion) {
    const Plan plan = make_plan(snapshot, {}, {.culler = culler, .draw = true, .occlusion = occlusion});
    return *std::ranges::find(plan.entries, "occlusion test", &PlanEntry::feature);
  };
  core::Scene scene;
  add_grid(scene, 25);  // 15,625 items
  ASSERT_TRUE(scene.commit());
  constexpr auto kAutomatic = OcclusionChoice::kAutomatic;
  for (const CullerChoice culler : {CullerChoice::kCpu, CullerChoice::kGpu, CullerChoice::kHybrid}) {
    const core::Snapshot few(scene);
    EXPECT_FALSE(entry_of(few, culler, kAutomatic).used) << name_of(culler);
    EXPECT_TRUE(entry_of(few, culler, OcclusionChoice::kOn).used) << name_of(culler);
  }
  add_grid(scene, 20);
  ASSERT_TRUE(scene.commit());
  const core::Snapshot more(scene);
  EXPECT_EQ(entry_of(more, CullerChoice::kCpu, kAutomatic).why, "while it pays");
  EXPECT_EQ(entry_of(more, CullerChoice::kHybrid, kAutomatic).why, "where the CPU culls: while it pays");
  EXPECT_FALSE(entry_of(more, CullerChoice::kGpu, kAutomatic).used);
  EXPECT_EQ(entry_of(more, CullerChoice::kGpu, kAutomatic).why, "23625 items, fewer than 100000: too few to profit");
  add_grid(scene, 56);
  ASSERT_TRUE(scene.commit());
  const core::Snapshot many(scene);
  EXPECT_TRUE(entry_of(many, CullerChoice::kGpu, kAutomatic).used);
  EXPECT_EQ(entry_of(many, CullerChoice::kHybrid, kAutomatic).why, "where a GPU culls; elsewhere while it pays");
  EXPECT_FALSE(entry_of(many, CullerChoice::kCpu, OcclusionChoice::kOff).used);
  EXPECT_EQ(entry_of(many, CullerChoice::kCpu, kAutomatic).why, "while it pays");
}

TEST(Engine, CullersMayBeChangedBetweenEdits) {
  core::Scene scene;
  add_grid(scene, 9);
  auto engine = Engine::create(scene);
  ASSERT_TRUE(engine);
  constexpr unsigned kSeed = 8;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937 random{kSeed};
  for (int round = 0; round < 30; ++round) {
    SCOPED_TRACE(round);
    for (int i = 0; i < 40; ++i) {
      const dvec3 place(random() % 12, random() % 12, random() % 12);
      if (random() % 2 == 0)
        scene.add_primitive(scene.root(), core::Sphere{1}, core::translation(place));
      else
        scene.set_placement(core::ItemId(random() % scene.item_slots()), core::translation(place));
    }
    ASSERT_TRUE(engine->commit());  // a rebuild may be on its way
    const CullerChoice choices[] = {CullerChoice::kAutomatic, CullerChoice::kCpu, CullerChoice::kLinear};
    const char* const names[] = {"cpu", "cpu", "linear"};
    const std::size_t choice = random() % 3;
    const CullerChoice before = engine->plan().culler;
    ASSERT_TRUE(engine->set_culler(choices[choice]));
    if (engine->plan().culler != before) {
      EXPECT_FALSE(engine->rebuilding());
    }
    EXPECT_EQ(name_of(engine->plan().culler), names[choice]);
    auto fresh = Engine::create(scene, {.culling = {.culler = CullerChoice::kLinear}});
    ASSERT_TRUE(fresh);
    for (const View& view : {look({-5, 4, 4}, {4, 4, 4}), look({4, 4, 4}, {8, 5, 3})}) {
      const auto report = engine->frame(view);
      ASSERT_TRUE(report && fresh->frame(view));
      EXPECT_EQ(name_of(report->culler), names[choice]);
      EXPECT_EQ(visible_items(*engine), visible_items(*fresh));
    }
  }
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
  auto linear = Engine::create(scene, {.culling = {.culler = CullerChoice::kLinear}});
  ASSERT_TRUE(linear);
  std::mt19937 random{7};
  for (int round = 0; round < 20; ++round) {
    SCOPED_TRACE(round);
    auto edited = Engine::create(scene, {.culling = {.culler = CullerChoice::kCpu}});
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
    auto fresh = Engine::create(scene, {.culling = {.culler = CullerChoice::kLinear}});
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

// --- rebuild in the background ---------------------------------------------------------------------------------------

/// Moves, removes, hides and inserts.
void edit(core::Scene& scene, std::mt19937& random, int count) {
  for (int i = 0; i < count; ++i) {
    const dvec3 place(random() % 25, random() % 25, random() % 25);
    const core::ItemId item = core::ItemId(random() % scene.item_slots());
    if (!scene.contains_item(item) || random() % 6 == 0)
      scene.add_primitive(scene.root(), core::Sphere{1}, core::translation(place));
    else if (random() % 5 == 0)
      scene.remove_item(item);
    else if (random() % 5 == 0)
      scene.set_visible(item, random() % 3 != 0);
    else
      scene.set_placement(item, core::translation(place));
  }
}

void expect_like_new(Engine& engine, core::Scene& scene) {
  auto fresh = Engine::create(scene, {.culling = {.culler = CullerChoice::kLinear}});
  ASSERT_TRUE(fresh);
  for (const View& view : {look({-9, 8, 8}, {8, 8, 8}), look({8, 8, 8}, {16, 9, 7}), look({90, 90, 90}, {0, 0, 0})}) {
    ASSERT_TRUE(engine.frame(view) && fresh->frame(view));
    EXPECT_EQ(engine.visible().generation, engine.snapshot().generation());
    EXPECT_EQ(visible_items(engine), visible_items(*fresh));
  }
}

TEST(EngineRebuild, LandsBetweenEditsThatGoOn) {
  for (const CullerChoice choice : {CullerChoice::kCpu, CullerChoice::kLinear}) {
    core::Scene scene;
    add_grid(scene, 20);
    auto engine = Engine::create(scene, {.culling = {.culler = choice}});
    ASSERT_TRUE(engine);
    std::mt19937 random{11};
    std::uint64_t generation = engine->snapshot().generation();
    int landed = 0;
    // A busy machine may need more edits until a version that is made beside them lands.
    for (int round = 0; round < 150 || (landed == 0 && round < 20'000); ++round) {
      SCOPED_TRACE(round);
      edit(scene, random, 100);
      ASSERT_TRUE(engine->commit());
      if (round % 30 == 0) {
        ASSERT_NO_FATAL_FAILURE(expect_like_new(*engine, scene));
      }
      landed += engine->snapshot().generation() != generation;
      generation = engine->snapshot().generation();
    }
    while (engine->rebuilding()) {
      ASSERT_TRUE(engine->frame(look({-9, 8, 8}, {8, 8, 8})));
      std::this_thread::yield();
    }
    EXPECT_NE(engine->snapshot().generation(), 1u);
    EXPECT_GT(landed, 0);
    EXPECT_LT(engine->snapshot().size(), 2 * scene.item_count());
    ASSERT_NO_FATAL_FAILURE(expect_like_new(*engine, scene));
  }
}

/// Edits that are pending when a new scene version lands show with their own commit, not before.
TEST(EngineRebuild, LandingReadsNothingOfTheScene) {
  core::Scene scene;
  add_grid(scene, 16);
  auto engine = Engine::create(scene);
  ASSERT_TRUE(engine);
  std::mt19937 random{12};
  edit(scene, random, 1000);
  ASSERT_TRUE(engine->commit());
  ASSERT_TRUE(engine->rebuilding());
  const View view = look({90, 90, 90}, {0, 0, 0});
  const std::uint64_t generation = engine->snapshot().generation();
  ASSERT_TRUE(engine->frame(view));  // may see it land already
  const std::vector<core::ItemId> before = visible_items(*engine);
  core::ItemId item{0};
  while (!scene.contains_item(item)) ++item;
  scene.set_placement(item, core::translation(dvec3(std::numeric_limits<double>::quiet_NaN())));
  for (core::ItemId i = core::ItemId(to_index(item) + 1); to_index(i) < scene.item_slots();
       i = core::ItemId{to_index(i) + 2})
    if (scene.contains_item(i)) scene.remove_item(i);
  while (engine->snapshot().generation() == generation) {
    ASSERT_TRUE(engine->frame(view));
    std::this_thread::yield();
  }
  EXPECT_EQ(visible_items(*engine), before);
  EXPECT_FALSE(engine->commit());
  scene.set_placement(item, {});
  ASSERT_TRUE(engine->commit());
  expect_like_new(*engine, scene);
}

TEST(EngineRebuild, MayBeMovedDestroyedOrStoppedAtAnyTime) {
  std::mt19937 random{13};
  for (int round = 0; round < 40; ++round) {
    core::Scene scene, other_scene;
    add_grid(scene, 14);
    add_grid(other_scene, 8);
    auto engine = Engine::create(scene), other = Engine::create(other_scene);
    ASSERT_TRUE(engine && other);
    edit(scene, random, 600);
    edit(other_scene, random, 300);
    ASSERT_TRUE(engine->commit() && other->commit());
    ASSERT_TRUE(engine->rebuilding());
    for (auto wait = random() % 2000; wait > 0; --wait) std::this_thread::yield();
    switch (round % 4) {
      case 0:
        break;  // destroyed
      case 1:
        *other = std::move(*engine);
        edit(scene, random, 50);
        ASSERT_TRUE(other->commit());
        ASSERT_NO_FATAL_FAILURE(expect_like_new(*other, scene));
        break;
      case 2: {
        Engine moved = std::move(*engine);
        ASSERT_NO_FATAL_FAILURE(expect_like_new(moved, scene));
        break;
      }
      default:
        ASSERT_TRUE(engine->rebuild());
        EXPECT_FALSE(engine->rebuilding());
        ASSERT_NO_FATAL_FAILURE(expect_like_new(*engine, scene));
    }
  }
}

/// From 256 slots and more than its share of all on.
TEST(EngineRebuild, BeginsAboveItsShare) {
  struct Case {
    int side;
    double share;
    core::ItemId most;  // slots given up without a new scene version
  };
  for (const auto& [side, share, most] : {Case{20, 1.0 / 16.0, core::ItemId{500}},
                                          Case{20, 1.0 / 8.0, core::ItemId{1000}}, Case{20, 1e-3, core::ItemId{256}}}) {
    core::Scene scene;
    add_grid(scene, side);
    auto engine = Engine::create(scene, {.culling = {.rebuild_share = share}});
    ASSERT_TRUE(engine);
    for (core::ItemId item{0}; item < most; ++item) scene.remove_item(item);
    ASSERT_TRUE(engine->commit());
    EXPECT_EQ(engine->snapshot().disorder(), to_index(most));
    EXPECT_FALSE(engine->rebuilding()) << share;
    scene.remove_item(most);
    ASSERT_TRUE(engine->commit());
    EXPECT_TRUE(engine->rebuilding()) << share;
  }
}

/// An edit comes between the end of the build and the exchange: the exchange waits until it is caught up with.
TEST(EngineRebuild, WhatLandsShowsTheLastEdit) {
  for (int round = 0; round < 60; ++round) {
    SCOPED_TRACE(round);
    core::Scene scene;
    add_grid(scene, 7);
    ASSERT_TRUE(scene.commit());
    const PlanRequest request{CullerChoice::kCpu};
    SceneVersion live = make_version(std::make_unique<core::Snapshot>(scene), request);
    const std::uint64_t first = live.snapshot->generation();
    BackgroundRebuild rebuild(*live.snapshot, request);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));  // mostly enough for the build
    const core::ItemId hidden = core::ItemId(round), removed = core::ItemId(100 + round);
    scene.set_visible(hidden, false);
    scene.remove_item(removed);
    const auto delta = scene.commit();
    ASSERT_TRUE(delta);
    rebuild.edit(*delta, [&] { live.snapshot->apply(*delta); });
    SceneVersion made;
    while (!rebuild.take(made)) std::this_thread::yield();
    std::swap(live, made);
    rebuild.retire(std::move(made));
    EXPECT_NE(live.snapshot->generation(), first);
    EXPECT_TRUE(live.snapshot->vacant(live.snapshot->slot(hidden)));
    EXPECT_EQ(live.snapshot->slot(removed), core::kNone);
  }
}

TEST(EngineRebuild, NeverWhenNotWanted) {
  core::Scene scene;
  add_grid(scene, 12);
  auto engine = Engine::create(scene, {.culling = {.rebuild_share = 0.0}});
  ASSERT_TRUE(engine);
  std::mt19937 random{14};
  edit(scene, random, 2000);
  ASSERT_TRUE(engine->commit());
  EXPECT_FALSE(engine->rebuilding());
  expect_like_new(*engine, scene);
}

// --- several engines -------------------------------------------------------------------------------------------------

/// Each follows every edit, whoever commits it, from its own commit on; one of them in new scene versions all the time.
TEST(EnginesOfOneScene, AllFollowWhoeverCommits) {
  constexpr unsigned kSeed = 15;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937 random{kSeed};
  core::Scene scene;
  add_grid(scene, 16);
  std::vector<Engine> engines;
  for (const EngineConfig& config : {EngineConfig{.culling = {.culler = CullerChoice::kLinear, .rebuild_share = 0.0}},
                                     EngineConfig{.culling = {.culler = CullerChoice::kCpu, .rebuild_share = 0.0}},
                                     EngineConfig{.culling = {.culler = CullerChoice::kCpu, .rebuild_share = 0.001}}}) {
    auto engine = Engine::create(scene, config);
    ASSERT_TRUE(engine);
    engines.push_back(std::move(*engine));
  }
  const View view = look_at_all();
  for (int round = 0; round < 60; ++round) {
    SCOPED_TRACE(round);
    std::vector<std::vector<core::ItemId>> before;
    for (Engine& engine : engines) {
      ASSERT_TRUE(engine.frame(view));
      before.push_back(visible_items(engine));
    }
    std::vector<bool> asked(engines.size());
    for (int part = 0; part < 3; ++part) {
      edit(scene, random, 60);
      const core::Scene::Mark mark = scene.mark();  // an import that fails
      const core::NodeId tried = scene.add_node(scene.root());
      scene.add_primitive(tried, core::Sphere{5}, core::translation(dvec3(8.0)), scene.add_material({}));
      scene.take_back(mark, std::vector{tried});
      switch (const std::size_t who = random() % 5) {
        case 3:
          ASSERT_TRUE(scene.commit()) << "the application";
          break;
        case 4:
          ASSERT_TRUE(engines[round % 3].rebuild());
          asked[round % 3] = true;
          break;
        default:
          ASSERT_TRUE(engines[who].commit());
          asked[who] = true;
      }
    }
    for (std::size_t i = 0; i < engines.size(); ++i) {
      ASSERT_TRUE(engines[i].frame(view));
      if (!asked[i]) {
        EXPECT_EQ(visible_items(engines[i]), before[i]) << "engine " << i << " has not asked yet";
      }
    }
    if (round % 4 != 0) continue;  // else they fall behind
    for (Engine& engine : engines) {
      ASSERT_TRUE(engine.commit());
      ASSERT_NO_FATAL_FAILURE(expect_like_new(engine, scene));
    }
    if (round % 20 != 0) continue;
    auto fresh = Engine::create(scene, {.culling = {.culler = CullerChoice::kCpu}});
    ASSERT_TRUE(fresh);
    engines[0] = std::move(*fresh);
  }
}

/// An error of one is an error of all, and costs none of them an edit.
TEST(EnginesOfOneScene, ARefusedCommitLosesNothing) {
  core::Scene scene;
  add_grid(scene, 4);
  auto a = Engine::create(scene), b = Engine::create(scene);
  ASSERT_TRUE(a && b);
  scene.remove_item(core::ItemId{0});
  ASSERT_TRUE(a->commit());
  scene.set_placement(core::ItemId{1}, core::translation(dvec3(std::numeric_limits<double>::quiet_NaN())));
  EXPECT_FALSE(b->commit());
  EXPECT_FALSE(a->commit());
  scene.set_placement(core::ItemId{1}, {});
  ASSERT_TRUE(b->commit() && a->commit());
  expect_like_new(*a, scene);
  expect_like_new(*b, scene);
}

/// Removed meshes stay in snapshots until their engine asks.
TEST(EnginesOfOneScene, AMeshMayGoBeforeAllHaveAsked) {
  core::Scene scene;
  add_grid(scene, 12);
  core::Mesh triangle;
  triangle.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  triangle.indices = {0, 1, 2};
  const core::MeshId mesh = scene.add_mesh(triangle).value();
  const core::ItemId item = scene.add_mesh_instance(scene.root(), mesh, core::translation({5, 5, 5}));
  auto a = Engine::create(scene), b = Engine::create(scene);
  ASSERT_TRUE(a && b);
  scene.remove_item(item);
  scene.remove_mesh(mesh);
  ASSERT_TRUE(a->commit());
  EXPECT_EQ(b->snapshot().mesh(b->snapshot().slot(item)).positions.size(), 3u);
  expect_like_new(*a, scene);
  ASSERT_TRUE(b->commit());
  expect_like_new(*b, scene);
}

/// A new scene version that was begun before the material was edited shows it all the same, also when no item was.
TEST(EngineRebuild, LandsWithTheMaterialsOfNow) {
  core::Scene scene;
  add_grid(scene, 16);
  const core::MaterialId paint = scene.add_material({});
  for (core::ItemId item{0}; to_index(item) < scene.item_slots(); item = core::ItemId{to_index(item) + 2})
    scene.set_material(item, paint);
  auto engine = Engine::create(scene);
  ASSERT_TRUE(engine);
  constexpr unsigned kSeed = 16;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937 random{kSeed};
  for (int round = 0; round < 20; ++round) {
    SCOPED_TRACE(round);
    edit(scene, random, 600);
    ASSERT_TRUE(engine->commit());
    ASSERT_TRUE(engine->rebuilding());
    for (auto wait = random() % 3000; wait > 0; --wait) std::this_thread::yield();
    core::Material look{.name = "look", .colour = {0, 0, float(round)}};
    scene.update_material(paint, look);
    look.colour.x = 1;
    const core::MaterialId added = scene.add_material(look);
    ASSERT_TRUE(engine->commit());
    while (engine->rebuilding()) {
      ASSERT_TRUE(engine->frame(look_at_all()));
      std::this_thread::yield();
    }
    ASSERT_GT(engine->snapshot().materials().size(), added.index);
    EXPECT_EQ(engine->snapshot().materials()[paint.index], glm::vec4(0, 0, round, 1));
    EXPECT_EQ(engine->snapshot().materials()[added.index], glm::vec4(1, 0, round, 1));
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

TEST(Engine, ConfigureRefusesAContextThatComesLater) {
  core::Scene scene;
  auto engine = engine::Engine::create(scene);
  ASSERT_TRUE(engine);
  engine::EngineConfig changed = engine->config();
  changed.context.later = true;
  const auto done = engine->configure(changed);
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().message.find("context_later"), std::string::npos) << done.error().message;
  EXPECT_FALSE(engine->config().context.later);
}

TEST(Engine, APauseIsNoFrameTime) {
  core::Scene scene;
  add_grid(scene, 3);
  auto engine = Engine::create(scene);
  ASSERT_TRUE(engine);
  const View view = look({-5, -5, 5}, {1, 1, 1});
  ASSERT_TRUE(engine->frame(view));
  EXPECT_GT(engine->frame(view)->frame_ms, 0.0);
  engine->paused();
  EXPECT_EQ(engine->frame(view)->frame_ms, 0.0);
  EXPECT_GT(engine->frame(view)->frame_ms, 0.0);
}

}  // namespace
}  // namespace sightline::engine::engine_test
