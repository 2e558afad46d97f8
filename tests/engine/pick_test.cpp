// Picks: what a view shows at a point, through edits and new scene versions.
#include "sightline/engine/pick.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <random>
#include <thread>

#include <gtest/gtest.h>

#include "sightline/engine/engine.h"
#include "sightline/gpuprims/internal/primitives.h"

namespace sightline::engine::pick_test {
namespace {

using core::dvec3;

/// A square of n x n balls of 0.8 m diameter, one metre apart, seen from above in an image of 100 pixels a ball.
struct Balls {
  core::Scene scene;
  int n;
  std::vector<core::ItemId> items;
  core::View view;

  explicit Balls(int count)
      : n(count),
        view(*core::View::orthographic({dvec3(0.5 * n, 0.5 * n, 10.0), dvec3(0.5 * n, 0.5 * n, 0.0), {0, 1, 0}}, n, 1.0,
                                       1.0, 100.0)) {
    for (int i = 0; i < n * n; ++i)
      items.push_back(scene.add_primitive(scene.root(), core::Sphere{0.8f}, at(i % n, i / n)));
  }
  static core::Affine at(int x, int y) { return core::translation({x + 0.5, y + 0.5, 0.0}); }
  EngineConfig config() const { return {.width = 100 * n, .height = 100 * n}; }
  /// The item picked at the middle of a place; kNone: nothing.
  core::ItemId pick(Engine& engine, int x, int y) const {
    const auto hit = engine.pick(view, 100.0 * x + 50.0, 100.0 * (n - y) - 50.0);
    EXPECT_TRUE(hit) << hit.error().message;
    return *hit ? (*hit)->item : core::kNoItem;
  }
};

TEST(Pick, FindsWhatTheViewShows) {
  Balls balls(5);
  auto engine = Engine::create(balls.scene, balls.config());
  ASSERT_TRUE(engine);
  EXPECT_EQ(engine->memory().tracer, 0u);
  for (int i = 0; i < 25; ++i) EXPECT_EQ(balls.pick(*engine, i % 5, i / 5), balls.items[std::size_t(i)]);
  EXPECT_GT(engine->memory().tracer, 0u);
  EXPECT_FALSE(*engine->pick(balls.view, 1.0, 1.0)) << "between the balls";
  const auto hit = engine->pick(balls.view, 150.0, 450.0);
  ASSERT_TRUE(hit && *hit);
  EXPECT_LT(glm::length((*hit)->point - dvec3(1.5, 0.5, 0.4)), 1e-7);

  core::View cut = balls.view;
  cut.sections.push_back({{0, 0, -1}, 0.0});
  const auto inside = engine->pick(cut, 150.0, 450.0);
  ASSERT_TRUE(inside && *inside);
  EXPECT_NEAR((*inside)->point.z, 0.0, 1e-7);
  EXPECT_EQ((*inside)->face, core::Face::kCut);
  cut.layers = core::kLayerInsulation;
  EXPECT_FALSE(*engine->pick(cut, 150.0, 450.0));

  const auto ray = engine->pick(core::Ray{{2.5, 2.5, 50.0}, {0, 0, -1}});
  ASSERT_TRUE(ray && *ray);
  EXPECT_NEAR((*ray)->t, 49.6, 1e-7);
  EXPECT_FALSE(engine->pick(core::Ray{{0, 0, 0}, {0, 0, 0}}));
}

/// Whatever is done while the tracer is made, picks are those of an engine that makes it at the first pick.
TEST(Pick, MayBePreparedInTheBackground) {
  constexpr unsigned kSeed = 4;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937 random{kSeed};
  for (int round = 0; round < 60; ++round) {
    SCOPED_TRACE(round);
    Balls balls(30);
    auto engine = Engine::create(balls.scene, balls.config());
    ASSERT_TRUE(engine);
    engine->prepare_picks();
    engine->prepare_picks();
    const core::ItemId one = balls.items[random() % balls.items.size()];
    switch (random() % 7) {
      case 0:
        ASSERT_TRUE(engine->hide({&one, 1}));
        break;
      case 1:
        balls.scene.remove_item(one);
        ASSERT_TRUE(engine->commit());
        break;
      case 2:
        balls.scene.set_placement(one, Balls::at(-1, -1));
        ASSERT_TRUE(engine->commit() && engine->frame(balls.view));
        break;
      case 3:
        ASSERT_TRUE(engine->rebuild());
        break;
      case 4: {
        Engine moved = std::move(*engine);
        *engine = std::move(moved);
        break;
      }
      case 5:
        ASSERT_TRUE(engine->set_culler(CullerChoice::kLinear) && engine->frame(balls.view));
        break;
      default:
        engine = Engine::create(balls.scene, balls.config());  // destroys it
        break;
    }
    auto twin = Engine::create(balls.scene, balls.config());
    ASSERT_TRUE(twin);
    if (random() % 2 == 0) engine->prepare_picks();
    for (int i = 0; i < 900; ++i) {
      const core::ItemId expected = balls.pick(*twin, i % 30, i / 30), found = balls.pick(*engine, i % 30, i / 30);
      if (expected != found) {
        EXPECT_EQ(expected, one);  // hidden in the engine alone
        EXPECT_EQ(found, core::kNoItem);
      }
    }
    EXPECT_GT(engine->memory().tracer, 0u);
  }
}

/// Edits stop the tracer that is being made, and in the end there is one that knows them all. So does the engine's end.
TEST(Pick, EditsInterruptThePreparation) {
  constexpr unsigned kSeed = 12;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937 random{kSeed};
  for (int round = 0; round < 12; ++round) {
    SCOPED_TRACE(round);
    Balls balls(200);
    auto engine = Engine::create(balls.scene, balls.config());
    ASSERT_TRUE(engine);
    EXPECT_FALSE(engine->preparing_picks());
    engine->prepare_picks();
    std::vector<std::size_t> hidden;
    for (auto edits = random() % 12; edits > 0; --edits) {
      std::this_thread::sleep_for(std::chrono::microseconds(random() % 4000));
      const std::size_t place = random() % balls.items.size();
      hidden.push_back(place);
      if (edits % 2 == 0) {
        balls.scene.set_visible(balls.items[place], false);
        ASSERT_TRUE(engine->commit());
      } else {
        ASSERT_TRUE(engine->hide({&balls.items[place], 1}));
      }
    }
    if (round % 4 == 3) continue;  // destroyed while it is made
    while (engine->preparing_picks()) std::this_thread::yield();
    for (int i = 0; i < 2000; ++i) {
      const std::size_t place = i < int(hidden.size()) ? hidden[std::size_t(i)] : random() % balls.items.size();
      const bool gone = std::find(hidden.begin(), hidden.end(), place) != hidden.end();
      EXPECT_EQ(balls.pick(*engine, int(place % 200), int(place / 200)), gone ? core::kNoItem : balls.items[place]);
    }
  }
}

TEST(Pick, TellsNodeAndFace) {
  Balls balls(1);
  const core::NodeId node = balls.scene.add_node(balls.scene.root(), "shelf");
  const core::ItemId box = balls.scene.add_primitive(node, core::Box{1, 1, 1}, core::translation({0.5, 0.5, -2.0}));
  auto engine = Engine::create(balls.scene, balls.config());
  ASSERT_TRUE(engine);
  const auto ball = engine->pick(balls.view, 50.0, 50.0);
  ASSERT_TRUE(ball && *ball);
  EXPECT_EQ((*ball)->node, balls.scene.root());
  EXPECT_EQ((*ball)->face, core::Face::kSide);
  const auto shelf = engine->pick(balls.view, 2.0, 2.0);  // beside the ball
  ASSERT_TRUE(shelf && *shelf);
  EXPECT_EQ((*shelf)->item, box);
  EXPECT_EQ((*shelf)->node, node);
  EXPECT_EQ((*shelf)->face, core::Face::kTop);
  balls.scene.remove_item(box);  // the engine shows it until it commits
  const auto removed = engine->pick(balls.view, 2.0, 2.0);
  ASSERT_TRUE(removed && *removed);
  EXPECT_EQ((*removed)->item, box);
  EXPECT_EQ((*removed)->node, node);
}

TEST(Pick, DoesNotFindHiddenItems) {
  for (const bool picked_before : {false, true}) {
    Balls balls(4);
    const core::ItemId behind =
        balls.scene.add_primitive(balls.scene.root(), core::Box{1, 1, 0.1f}, core::translation({0.5, 0.5, -3.0}));
    auto engine = Engine::create(balls.scene, balls.config());
    ASSERT_TRUE(engine);
    if (picked_before) {
      EXPECT_EQ(balls.pick(*engine, 0, 0), balls.items[0]);
    }
    const core::ItemId hidden[] = {balls.items[0], balls.items[5]};
    ASSERT_TRUE(engine->hide(hidden));
    EXPECT_EQ(balls.pick(*engine, 0, 0), behind);
    EXPECT_EQ(balls.pick(*engine, 1, 1), core::kNoItem);
    EXPECT_EQ(balls.pick(*engine, 2, 1), balls.items[6]);
    const auto seen = engine->visible_items_in(balls.view, {10, 210, 190, 390});
    ASSERT_TRUE(seen);
    std::vector<core::ItemId> found;
    for (const raytrace::VisibleItem& item : *seen) found.push_back(item.item);
    EXPECT_EQ(found, (std::vector<core::ItemId>{balls.items[1], balls.items[4], behind}));
    ASSERT_TRUE(engine->show({hidden, 1}));
    EXPECT_EQ(balls.pick(*engine, 0, 0), balls.items[0]);
    ASSERT_TRUE(engine->rebuild());
    EXPECT_EQ(balls.pick(*engine, 1, 1), core::kNoItem);
    ASSERT_TRUE(engine->show_all());
    EXPECT_EQ(balls.pick(*engine, 1, 1), balls.items[5]);
  }
}

TEST(Pick, GoesThroughGhostsUnlessAsked) {
  Balls balls(3);
  const core::ItemId behind =
      balls.scene.add_primitive(balls.scene.root(), core::Box{1, 1, 0.1f}, core::translation({0.5, 0.5, -3.0}));
  const core::ItemId inside =
      balls.scene.add_primitive(balls.scene.root(), core::Box{0.2f, 0.2f, 0.2f}, Balls::at(1, 1));
  auto engine = Engine::create(balls.scene, balls.config());
  ASSERT_TRUE(engine);
  const core::ItemId ghosts[] = {balls.items[0], balls.items[4], balls.items[8]};
  ASSERT_TRUE(engine->set_override(ghosts, {.ghost = true}));
  EXPECT_EQ(balls.pick(*engine, 0, 0), behind);
  EXPECT_EQ(balls.pick(*engine, 1, 1), inside);
  EXPECT_EQ(balls.pick(*engine, 2, 2), core::kNoItem);
  EXPECT_EQ(balls.pick(*engine, 1, 0), balls.items[1]);
  const auto asked = engine->pick(balls.view, 50.0, 250.0, Ghosts::kHit);
  ASSERT_TRUE(asked && *asked);
  EXPECT_EQ((*asked)->item, balls.items[0]);
  const auto ray = engine->pick(core::Ray{{1.5, 1.5, 9.0}, {0, 0, -1}});
  ASSERT_TRUE(ray && *ray);
  EXPECT_EQ((*ray)->item, inside);
  const auto seen = engine->visible_items_in(balls.view, {0, 0, 300, 300});
  ASSERT_TRUE(seen);
  std::vector<core::ItemId> found;
  for (const raytrace::VisibleItem& item : *seen) found.push_back(item.item);
  std::vector<core::ItemId> wanted = balls.items;
  std::erase_if(wanted, [&](core::ItemId item) { return std::find(ghosts, ghosts + 3, item) != ghosts + 3; });
  wanted.insert(wanted.end(), {behind, inside});
  EXPECT_EQ(found, wanted);
  ASSERT_TRUE(engine->rebuild() && engine->clear_override({ghosts, 1}));
  EXPECT_EQ(balls.pick(*engine, 0, 0), balls.items[0]);
  EXPECT_EQ(balls.pick(*engine, 1, 1), inside);
}

TEST(Pick, FindsItemsInRectangles) {
  Balls balls(10);
  const core::ItemId behind =
      balls.scene.add_primitive(balls.scene.root(), core::Box{0.1f, 0.1f, 0.1f}, core::translation({0.5, 0.5, -3.0}));
  for (const CullerChoice culler : {CullerChoice::kLinear, CullerChoice::kCpu}) {
    EngineConfig config = balls.config();
    config.culling.culler = culler;
    auto engine = Engine::create(balls.scene, config);
    ASSERT_TRUE(engine);
    // The lower left four balls: of 80 pixels diameter, 20 pixels apart.
    const auto items_in = [&](PixelRectangle r, culling::RegionRule rule) {
      const auto items = engine->items_in(balls.view, r, rule);
      EXPECT_TRUE(items);
      return *items;
    };
    using Items = std::vector<core::ItemId>;
    const Items four{balls.items[0], balls.items[1], balls.items[10], balls.items[11], behind};
    EXPECT_EQ(items_in({5, 805, 195, 995}, culling::RegionRule::kWholly), four);
    EXPECT_EQ(items_in({195, 995, 5, 805}, culling::RegionRule::kCrossing), four);
    EXPECT_EQ(items_in({12, 805, 195, 995}, culling::RegionRule::kWholly),
              (Items{balls.items[1], balls.items[11], behind}));
    EXPECT_EQ(items_in({20, 820, 180, 980}, culling::RegionRule::kCrossing), four);
    // Within the ball's box, but beside the ball.
    EXPECT_EQ(items_in({11, 811, 17, 817}, culling::RegionRule::kCrossing), Items());
    EXPECT_EQ(items_in({50, 850, 50, 850}, culling::RegionRule::kCrossing), (Items{balls.items[10]}));
    const auto all = engine->items_in(std::vector<core::Plane>{{{0, 0, -1}, -1.0}}, culling::RegionRule::kWholly);
    ASSERT_TRUE(all);
    EXPECT_EQ(*all, Items{behind});
    EXPECT_FALSE(engine->items_in(std::vector<core::Plane>(9), culling::RegionRule::kWholly));
    EXPECT_EQ(engine->memory().tracer, 0u);

    const auto seen = engine->visible_items_in(balls.view, {5, 805, 195, 995}, 1);
    ASSERT_TRUE(seen);
    ASSERT_EQ(seen->size(), 4u) << "without the box behind a ball";
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_EQ((*seen)[i].item, four[i]);
      EXPECT_NEAR(double((*seen)[i].samples), 1600.0 * 3.14159, 30.0);
    }
    EXPECT_TRUE(engine->visible_items_in(balls.view, {-50, -50, -10, -10})->empty());
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(engine->visible_items_in(balls.view, {nan, 0, 1, 1}));
    EXPECT_FALSE(engine->items_in(balls.view, {0, nan, 1, 1}, culling::RegionRule::kWholly));
    // The samples of a part of the image are those of the whole.
    const auto whole = engine->visible_items_in(balls.view, {0, 0, 1000, 1000}, 4);
    const auto left = engine->visible_items_in(balls.view, {0, 0, 333, 1000}, 4);
    const auto right = engine->visible_items_in(balls.view, {333, 0, 1000, 1000}, 4);
    ASSERT_TRUE(whole && left && right);
    const auto samples = [](const std::vector<raytrace::VisibleItem>& some) {
      std::uint64_t sum = 0;
      for (const auto& item : some) sum += item.samples;
      return sum;
    };
    EXPECT_EQ(whole->size(), 100u);
    EXPECT_EQ(samples(*whole), samples(*left) + samples(*right));
  }
}

TEST(Pick, FollowsEditsAndNewVersions) {
  Balls balls(40);
  EngineConfig config = balls.config();
  config.culling.rebuild_share = 0.2;
  auto engine = Engine::create(balls.scene, config);
  ASSERT_TRUE(engine);
  EXPECT_EQ(balls.pick(*engine, 3, 4), balls.items[163]);
  // Each round moves every ball of a row to another row, which in the end brings a new scene version.
  for (int round = 0; round < 39; ++round) {
    for (int x = 0; x < 40; ++x) {
      std::swap(balls.items[std::size_t(40 * round + x)], balls.items[std::size_t(40 * 39 + x)]);
      for (const int y : {round, 39}) balls.scene.set_placement(balls.items[std::size_t(40 * y + x)], Balls::at(x, y));
    }
    const core::ItemId removed = balls.items[std::size_t(40 * 39 + round)];
    balls.scene.set_visible(removed, false);
    ASSERT_TRUE(engine->commit());
    for (int i = 0; i < 1600; i += 7)
      ASSERT_EQ(balls.pick(*engine, i % 40, i / 40),
                balls.items[std::size_t(i)] == removed ? core::kNoItem : balls.items[std::size_t(i)])
          << "round " << round << ", place " << i;
    balls.scene.set_visible(removed, true);
  }
  const std::uint64_t before = engine->snapshot().generation();
  ASSERT_TRUE(engine->rebuild());
  EXPECT_NE(engine->snapshot().generation(), before);
  for (int i = 0; i < 1600; ++i) ASSERT_EQ(balls.pick(*engine, i % 40, i / 40), balls.items[std::size_t(i)]);
}

/// An order made in the background comes with its tracer.
/// What picks keep of a mesh comes back with the commit that follows its removal, though another one has its index.
TEST(Pick, ForgetsMeshesThatAreGone) {
  Balls balls(3);
  core::Scene& scene = balls.scene;
  scene.reuse_ids(true);
  auto engine = Engine::create(scene, balls.config());
  ASSERT_TRUE(engine);
  EXPECT_EQ(balls.pick(*engine, 1, 1), balls.items[4]);
  std::size_t first = 0;
  for (int round = 0; round < 40; ++round) {
    core::Mesh plate = gpuprims::tessellate(core::Sphere{0.5f}, {.fixed_segments = 40});
    const core::MeshId mesh = scene.add_mesh(std::move(plate)).value();
    const core::ItemId item = scene.add_mesh_instance(scene.root(), mesh, core::translation({1.5, 1.5, 5.0}));
    const core::ItemId other = scene.add_mesh_instance(scene.root(), mesh, core::translation({0.5, 0.5, 5.0}));
    ASSERT_TRUE(engine->commit());
    ASSERT_EQ(balls.pick(*engine, 1, 1), item);
    if (round == 0) first = engine->memory().tracer;
    EXPECT_LE(engine->memory().tracer, first + (std::size_t(1) << 16)) << round;
    scene.remove_item(item);
    ASSERT_TRUE(engine->commit());
    ASSERT_EQ(balls.pick(*engine, 0, 0), other);
    scene.remove_item(other);
    scene.remove_mesh(mesh);
    if (round % 2 == 0) {  // else another mesh comes in the same commit
      ASSERT_TRUE(engine->commit());
      ASSERT_EQ(balls.pick(*engine, 1, 1), balls.items[4]);
    }
  }
}

TEST(Pick, FollowsBackgroundRebuilds) {
  Balls balls(40);
  EngineConfig config = balls.config();
  config.culling.rebuild_share = 0.01;
  auto engine = Engine::create(balls.scene, config);
  ASSERT_TRUE(engine);
  EXPECT_EQ(balls.pick(*engine, 0, 0), balls.items[0]);
  const std::uint64_t before = engine->snapshot().generation();
  std::mt19937_64 random(1);
  std::shuffle(balls.items.begin(), balls.items.end(), random);
  for (int i = 0; i < 1600; ++i) balls.scene.set_placement(balls.items[std::size_t(i)], Balls::at(i % 40, i / 40));
  ASSERT_TRUE(engine->commit());
  for (int tries = 0; engine->snapshot().generation() == before; ++tries) {
    ASSERT_LT(tries, 20'000) << "no new scene version";
    ASSERT_TRUE(engine->frame(balls.view));
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_GT(engine->memory().tracer, 0u);
  for (int i = 0; i < 1600; ++i) ASSERT_EQ(balls.pick(*engine, i % 40, i / 40), balls.items[std::size_t(i)]);
}

}  // namespace
}  // namespace sightline::engine::pick_test
