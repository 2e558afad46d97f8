// Overrides: an engine that overrides items draws, culls and finds what one does on a scene that really is so.
#include <algorithm>
#include <limits>
#include <map>
#include <random>

#include <gtest/gtest.h>

#include "sightline/core/scene.h"
#include "sightline/engine/internal/engine_parts.h"
#include "sightline/tests/engine/drawing_modes.h"

namespace sightline::tests::overrides_test {
namespace {

using core::ItemId;
using engine::CullerChoice;
using engine::Engine;
using engine::EngineConfig;
using engine::ItemStyle;

constexpr core::vec3 kRed{0.9f, 0.1f, 0.1f}, kBlue{0.1f, 0.2f, 0.9f};

/// A scene, an engine that overrides its items, and the scene that really is as the engine shows it.
class OverridesTest : public DrawnGrid {
 protected:
  struct State {
    ItemStyle style;
    bool hidden = false;
  };

  void SetUp() override {
    DrawnGrid::SetUp();
    if (!context) return;
    for (core::Scene* s : {&scene, &twin}) {
      for (int i = 0; i < 3; ++i)
        materials[i] = s->add_material({"", {0.3f * float(i), 0.5f, 0.2f}, i == 2 ? 0.5f : 1.0f});
      for (int i = 0; i < 4; ++i) nodes[i] = s->add_node(s->root());
      core::Mesh mesh;
      mesh.positions = {{0, 0, 0}, {0.6f, 0, 0}, {0, 0.6f, 0}, {0, 0, 0.6f}};
      mesh.indices = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
      meshes = *s->add_mesh(mesh);
      for (int i = 0; i < kSide * kSide * kSide; ++i) add(*s, i, {i % kSide, i / kSide % kSide, i / kSide / kSide});
    }
    items = ItemId(kSide * kSide * kSide);
  }

  void add(core::Scene& to, int i, const core::dvec3& origin) {
    const core::Affine at = core::translation(origin);
    const core::NodeId node = nodes[i % 4];
    const core::MaterialId material = i % 5 < 3 ? materials[i % 5] : core::MaterialId();
    if (i % 7 == 0)
      to.add_mesh_instance(node, meshes, at, material);
    else if (i % 7 == 1)
      to.add_primitive(node, core::Line{}, at, material);
    else if (i % 2 == 0)
      to.add_primitive(node, core::Box{0.4f, 0.4f, 0.4f}, at, material);
    else
      to.add_primitive(node, core::Cylinder{0.2f, 0.5f}, at, material);
  }

  /// Makes the twin what the overrides say, with materials and visibility of its own.
  void imitate() {
    std::map<std::array<float, 4>, core::MaterialId> looks;
    for (ItemId item{0}; item < items; ++item) {
      if (!scene.contains_item(item)) continue;
      const State& s = states[item];
      twin.set_visible(item, scene.item_visible(item) && !s.hidden);
      const core::MaterialId own = scene.item_material(item);
      core::Material look = own.valid() ? scene.material(own) : core::Material();
      if (s.style.colour) look.colour = *s.style.colour;
      look.alpha *= s.style.alpha;
      const auto [at, fresh] = looks.try_emplace({look.colour.r, look.colour.g, look.colour.b, look.alpha});
      if (fresh) at->second = twin.add_material(look);
      twin.set_material(item, at->second);
    }
  }

  /// What the engine says of its overrides.
  void expect_told(const Engine& engine) {
    std::vector<ItemId> styled, hidden;
    for (const auto& [item, state] : states) {
      const auto told = engine.override_of(item);
      ASSERT_EQ(told.has_value(), !(state.style == ItemStyle())) << to_index(item);
      if (told) {
        ASSERT_EQ(*told, state.style) << to_index(item);
        styled.push_back(item);
      }
      ASSERT_EQ(engine.is_hidden(item), state.hidden) << to_index(item);
      if (state.hidden) hidden.push_back(item);
    }
    ASSERT_EQ(engine.overridden_items(), styled);
    ASSERT_EQ(engine.hidden_items(), hidden);
    ASSERT_FALSE(engine.override_of(core::kNoItem) || engine.is_hidden(core::kNoItem));
  }

  EngineConfig configured(CullerChoice culler) {
    EngineConfig c = config(culler);
    c.drawing.ids = true;
    c.culling.rebuild_share = 0.0;
    return c;
  }
  core::View around(double turn) const {
    const core::dvec3 centre(0.5 * kSide),
        eye = centre + 1.1 * kSide * core::dvec3(std::cos(turn), std::sin(turn), 0.2);
    return *core::View::perspective({eye, centre, {0, 0, 1}}, 0.8, 1.5, 0.1);
  }
  static void expect_same(Engine& a, Engine& b, const core::View& view) {
    for (Engine* engine : {&a, &b}) {
      for (std::int64_t pending = 1; pending > 0;) {  // with a budget
        const auto report = engine->frame(view);
        ASSERT_TRUE(report) << report.error().message;
        pending = report->pending;
      }
    }
    EXPECT_EQ(*a.items_in(view, {0, 0, 192, 128}, culling::RegionRule::kCrossing),
              *b.items_in(view, {0, 0, 192, 128}, culling::RegionRule::kCrossing));
    a.finish();
    b.finish();
    const auto colour = image::compare(*a.read_colour(), *b.read_colour());
    ASSERT_TRUE(colour) << colour.error().message;
    EXPECT_EQ(colour->max, 0) << colour->pixels << " pixels";
    EXPECT_EQ(a.read_ids()->ids, b.read_ids()->ids);
  }

  static constexpr int kSide = 10;
  core::Scene scene, twin;
  core::MaterialId materials[3];
  core::NodeId nodes[4];
  core::MeshId meshes;
  ItemId items{0};
  std::map<ItemId, State> states;
};

const auto kModes = drawing_modes({
    {"no_sample_test",  // ranges that are drawn have vacant slots
     [](EngineConfig& c) {
       c.culling.occlusion = engine::OcclusionChoice::kOff;
       c.culling.sample_test = false;
     }},
    {"contribution", [](EngineConfig& c) { c.losses.min_projected_area = 30.0f; }},
    {"splats",
     [](EngineConfig& c) {
       c.losses.min_projected_area = 30.0f;
       c.losses.contribution_mode = engine::ContributionMode::kPoints;
     }},
});

class OverridesInAllModes : public OverridesTest, public testing::WithParamInterface<DrawingMode> {};
INSTANTIATE_TEST_SUITE_P(, OverridesInAllModes, testing::ValuesIn(kModes), name_of);

TEST_P(OverridesInAllModes, AreAsMaterialsAndVisibilityThroughAnyEdits) {
  const unsigned seed = 4711;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> anywhere(0.0, kSide);  // no two surfaces at the same depth
  const auto below = [&](std::size_t n) { return std::size_t(random() % n); };
  EngineConfig mode = configured(CullerChoice::kAutomatic);
  GetParam().set(mode);
  auto engine = Engine::create(scene, mode), really = Engine::create(twin, mode);
  ASSERT_TRUE(engine && really);
  const auto pick_items = [&] {
    std::vector<ItemId> picked;
    const std::size_t count = below(4) == 0 ? 1 : 1 + below(300);
    while (picked.size() < count)
      if (const ItemId item = ItemId(below(to_index(items))); scene.contains_item(item)) picked.push_back(item);
    return picked;
  };
  const ItemStyle styles[] = {{kRed}, {kBlue, 0.4f}, {{}, 0.5f}, {kRed, 0.0f}, {}};
  for (int step = 0; step < 80; ++step) {
    SCOPED_TRACE("step " + std::to_string(step));
    const std::vector<ItemId> picked = pick_items();
    switch (below(11)) {
      case 0:
      case 1: {
        const ItemStyle& style = styles[below(std::size(styles))];
        ASSERT_TRUE(engine->set_override(picked, style));
        for (const ItemId item : picked) states[item].style = style;
        break;
      }
      case 2:
        ASSERT_TRUE(engine->clear_override(picked));
        for (const ItemId item : picked) states[item].style = {};
        break;
      case 3:
        ASSERT_TRUE(engine->hide(picked));
        for (const ItemId item : picked) states[item].hidden = true;
        break;
      case 4:
        ASSERT_TRUE(engine->show(picked));
        for (const ItemId item : picked) states[item].hidden = false;
        break;
      case 5: {
        const core::NodeId isolated[] = {nodes[below(4)], nodes[below(4)]};
        ASSERT_TRUE(engine->isolate(isolated));
        for (ItemId item{0}; item < items; ++item) {
          const bool there = scene.contains_item(item);
          const core::NodeId node = there ? scene.node_of(item) : core::NodeId();
          states[item].hidden = there && node != isolated[0] && node != isolated[1];
        }
        break;
      }
      case 6:
        ASSERT_TRUE(below(2) == 0 ? engine->show_all() : engine->clear_overrides());
        for (ItemId item{0}; item < items; ++item) states[item] = {};
        ASSERT_TRUE(engine->show_all() && engine->clear_overrides());
        break;
      case 7:
        for (const ItemId item : picked) {
          if (!scene.contains_item(item)) continue;
          for (core::Scene* s : {&scene, &twin}) s->remove_item(item);
          states.erase(item);
        }
        break;
      case 8:
        for (const ItemId item : picked) {
          core::Affine placement = scene.placement(item);
          placement.origin = core::dvec3(anywhere(random), anywhere(random), anywhere(random));
          for (core::Scene* s : {&scene, &twin}) s->set_placement(item, placement);
          if (below(2) == 0) scene.set_material(item, materials[below(3)]);
          if (below(3) == 0) scene.set_visible(item, below(2) == 0);
        }
        break;
      case 9:
        for (int i = 0; i < 40; ++i, ++items) {
          const core::dvec3 at(anywhere(random), anywhere(random), anywhere(random));
          for (core::Scene* s : {&scene, &twin}) add(*s, int(items), at);
        }
        break;
      default:
        scene.update_material(materials[below(3)], {"", {0.1f * float(below(10)), 0.4f, 0.4f}, below(2) ? 1.0f : 0.3f});
        for (std::size_t i = below(200); i > 0; --i) scene.add_material({});  // until looks give way in the table
    }
    imitate();
    if (below(4) == 0) {
      ASSERT_TRUE(engine->rebuild() && really->rebuild());
    } else {
      ASSERT_TRUE(engine->commit() && really->commit());
    }
    for (Engine* e : {&*engine, &*really}) {  // what was large in the last frame depends on when slots were given up
      engine::LossConfig losses = mode.losses;
      losses.min_projected_area = 0.0f;
      engine::EngineParts::drawing(*e)->set_losses(losses);
      engine::EngineParts::drawing(*e)->set_losses(mode.losses);
    }
    ASSERT_NO_FATAL_FAILURE(expect_told(*engine));
    expect_same(*engine, *really, around(0.3 * step));
    if (HasFailure()) return;
  }
}

TEST_F(OverridesTest, OfWhatHangsOnNodes) {
  auto engine = Engine::create(scene, configured(CullerChoice::kCpu));
  ASSERT_TRUE(engine);
  const core::NodeId inner = scene.add_node(nodes[1]);
  const ItemId deep = scene.add_primitive(inner, core::Sphere{0.4f}, core::translation({3, 3, 3}));
  scene.remove_item(ItemId{2});
  const auto on = [&](std::initializer_list<int> wanted, bool with_deep) {
    std::vector<ItemId> found;
    for (ItemId item{0}; item < items; ++item)
      if (std::count(wanted.begin(), wanted.end(), int(to_index(item) % 4)) != 0) found.push_back(item);
    if (with_deep) found.push_back(deep);
    return found;
  };
  EXPECT_EQ(*engine->items_below({{nodes[1]}}), on({1}, false)) << "the last commit knows no more";
  ASSERT_TRUE(engine->commit());
  EXPECT_EQ(*engine->items_below({{nodes[1]}}), on({1}, true));
  EXPECT_EQ(*engine->items_below({{inner}}), std::vector{deep});
  EXPECT_EQ(*engine->items_below({{nodes[3], inner, nodes[1], nodes[3]}}), on({1, 3}, true));
  EXPECT_TRUE(engine->items_below({})->empty());
  EXPECT_EQ(engine->items_below({{scene.root()}})->size(), scene.item_count());
  ASSERT_TRUE(engine->hide(*engine->items_below({{nodes[1]}})));
  EXPECT_EQ(engine->hidden_items(), on({1}, true));
  scene.remove_node(inner);
  EXPECT_FALSE(engine->items_below({{nodes[0], inner}}));
}

TEST_F(OverridesTest, VersionsFromTheBackgroundAreOverridden) {
  const unsigned seed = 12;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  EngineConfig ordering = configured(CullerChoice::kCpu);
  ordering.culling.rebuild_share = 0.03;
  auto engine = Engine::create(scene, ordering);
  ASSERT_TRUE(engine);
  std::uniform_real_distribution<double> anywhere(0.0, kSide);
  int landed = 0;
  for (std::uint64_t generation = engine->snapshot().generation(); landed < 8;) {
    for (int i = 0; i < 40; ++i) {
      const ItemId item = ItemId(random() % to_index(items));
      if (i % 4 == 0) {
        const core::Affine to = core::translation({anywhere(random), anywhere(random), anywhere(random)});
        for (core::Scene* s : {&scene, &twin}) s->set_placement(item, to);
        continue;
      }
      State& state = states[item];
      state.style = i % 4 == 1 ? ItemStyle{kRed, 0.6f} : i % 4 == 2 ? ItemStyle{kBlue} : ItemStyle();
      state.hidden = i % 3 == 0;
      ASSERT_TRUE(engine->set_override({&item, 1}, state.style));
      ASSERT_TRUE(state.hidden ? engine->hide({&item, 1}) : engine->show({&item, 1}));
    }
    ASSERT_TRUE(engine->commit() && engine->frame(around(0)));
    if (engine->snapshot().generation() == generation) continue;
    generation = engine->snapshot().generation();
    SCOPED_TRACE("order " + std::to_string(++landed));
    imitate();
    auto really = Engine::create(twin, configured(CullerChoice::kCpu));
    ASSERT_TRUE(really);
    const core::View view = around(landed);
    ASSERT_TRUE(engine->frame(view) && really->frame(view));
    EXPECT_EQ(*engine->items_in(view, {0, 0, 192, 128}, culling::RegionRule::kCrossing),
              *really->items_in(view, {0, 0, 192, 128}, culling::RegionRule::kCrossing));
    expect_same_image(*engine, *really, 1);
  }
}

TEST_F(OverridesTest, OverridesGiveWayToMoreMaterials) {
  auto engine = Engine::create(scene, configured(CullerChoice::kCpu)),
       really = Engine::create(twin, configured(CullerChoice::kCpu));
  ASSERT_TRUE(engine && really);
  for (ItemId item{0}; item < items; item = ItemId{to_index(item) + 2}) {
    states[item].style = to_index(item) % 4 == 0 ? ItemStyle{kRed} : ItemStyle{kBlue, 0.7f};
    ASSERT_TRUE(engine->set_override({&item, 1}, states[item].style));
  }
  for (int round = 0; round < 3; ++round) {
    for (int i = 0; i < 300; ++i)
      scene.set_material(ItemId(2 * i + 1), scene.add_material({"", kBlue * (0.003f * float(i))}));
    imitate();
    ASSERT_TRUE(engine->commit() && really->commit());
    expect_same(*engine, *really, around(round));
  }
}

TEST_F(OverridesTest, TransparentItemsCoverNoEnds) {
  core::Scene pipe, other;
  for (core::Scene* s : {&pipe, &other}) {
    for (int i = 0; i < 3; ++i) materials[i] = s->add_material({});
    for (int i = 0; i < 8; ++i)
      s->add_primitive(s->root(), core::Cylinder{1.0f, 1.0f}, core::translation({6.5, 6.5, 3.0 + i}), materials[i % 3]);
  }
  auto engine = Engine::create(pipe, configured(CullerChoice::kCpu)),
       really = Engine::create(other, configured(CullerChoice::kCpu));
  ASSERT_TRUE(engine && really);
  std::size_t covered = engine::EngineParts::joints(*engine).count();
  ASSERT_EQ(covered, 14u);
  const auto expect_uncovered = [&](std::size_t ends) {
    EXPECT_EQ(engine::EngineParts::joints(*engine).count(), covered -= ends);
    ASSERT_TRUE(really->commit());
    EXPECT_EQ(engine::EngineParts::joints(*really).count(), covered);
    expect_same(*engine, *really, around(1));
  };
  const ItemId coloured[] = {ItemId{0}, ItemId{3}, ItemId{6}};  // of the first material
  ASSERT_TRUE(engine->set_override(coloured, {.colour = kRed}));
  for (const ItemId item : coloured) other.set_material(item, other.add_material({"", kRed}));
  ASSERT_TRUE(really->rebuild());
  EXPECT_EQ(engine::EngineParts::joints(*engine).count(), covered);
  const ItemId clear{1}, gone = ItemId{4};
  ASSERT_TRUE(engine->set_override({&clear, 1}, {.alpha = 0.25f}));
  other.set_material(clear, other.add_material({"", {0.7f, 0.7f, 0.7f}, 0.25f}));
  ASSERT_NO_FATAL_FAILURE(expect_uncovered(4));
  ASSERT_TRUE(engine->hide({&gone, 1}));
  other.set_visible(gone, false);
  ASSERT_NO_FATAL_FAILURE(expect_uncovered(4));
  pipe.update_material(materials[0], {"", {}, 0.5f});
  for (const ItemId item : coloured) other.update_material(other.item_material(item), {"", kRed, 0.5f});
  ASSERT_TRUE(engine->commit());
  ASSERT_NO_FATAL_FAILURE(expect_uncovered(6));
}

TEST_F(OverridesTest, TwoEnginesOnOneSceneShowItDifferently) {
  auto a = Engine::create(scene, configured(CullerChoice::kCpu)),
       b = Engine::create(scene, configured(CullerChoice::kGpu)),
       plain = Engine::create(twin, configured(CullerChoice::kCpu));
  ASSERT_TRUE(a && b && plain);
  std::vector<ItemId> some;
  for (ItemId item{0}; item < items; item = ItemId{to_index(item) + 3}) some.push_back(item);
  ASSERT_TRUE(a->set_override(some, {.colour = kRed}) && a->hide({&some[1], 1}));
  expect_same(*b, *plain, around(1));
  ASSERT_TRUE(b->isolate({&nodes[1], 1}));
  for (const ItemId item : some) states[item].style.colour = kRed;
  states[some[1]].hidden = true;
  imitate();
  ASSERT_TRUE(plain->commit());
  expect_same(*a, *plain, around(1));
}

TEST_F(OverridesTest, OutliveTheContext) {
  for (const CullerChoice culler : {CullerChoice::kCpu, CullerChoice::kGpu}) {
    auto other = gl::Context::create_offscreen();
    ASSERT_TRUE(other && context->make_current());
    auto engine = Engine::create(scene, configured(culler)), really = Engine::create(twin, configured(culler));
    ASSERT_TRUE(engine && really);
    std::vector<ItemId> red, gone;
    for (ItemId item{0}; item < items; ++item) (to_index(item) % 2 == 0 ? red : gone).push_back(item);
    ASSERT_TRUE(engine->set_override(red, {.colour = kRed, .alpha = 0.5f}));
    engine->drop_context();
    ASSERT_TRUE(engine->hide(gone)) << "without a context";
    for (const ItemId item : red) states[item].style = {.colour = kRed, .alpha = 0.5f};
    for (const ItemId item : gone) states[item].hidden = true;
    imitate();
    ASSERT_TRUE(really->commit() && really->frame(around(2)));
    const image::Image wanted = *really->read_colour();
    ASSERT_TRUE(other->make_current() && engine->use_context(*other) && engine->frame(around(2)));
    const auto difference = image::compare(wanted, *engine->read_colour());
    ASSERT_TRUE(difference);
    EXPECT_EQ(difference->max, 0);
    engine->drop_context();
    ASSERT_TRUE(context->make_current());
  }
}

TEST_F(OverridesTest, UnknownIdsAndBadStylesChangeNothing) {
  auto engine = Engine::create(scene, configured(CullerChoice::kCpu)),
       plain = Engine::create(twin, configured(CullerChoice::kCpu));
  ASSERT_TRUE(engine && plain);
  const ItemId removed{7}, uncommitted = ItemId(scene.item_slots());
  scene.remove_item(removed);
  twin.remove_item(removed);
  ASSERT_TRUE(engine->commit() && plain->commit());
  add(scene, 1, {1, 2, 3});
  for (const ItemId bad : {removed, uncommitted, ItemId{1'000'000'000}, core::kNoItem}) {
    const ItemId list[] = {ItemId{3}, ItemId{4}, bad, ItemId{5}};
    const auto expect_named = [&](const core::Expected<void>& done, const char* call) {
      ASSERT_FALSE(done);
      EXPECT_NE(done.error().message.find(std::to_string(to_index(bad))), std::string::npos) << done.error().message;
      EXPECT_NE(done.error().message.find(call), std::string::npos) << done.error().message;
    };
    expect_named(engine->set_override(list, {.colour = kRed}), "set_override");
    expect_named(engine->clear_override(list), "clear_override");
    expect_named(engine->hide(list), "hide");
    expect_named(engine->show(list), "show");
  }
  const core::NodeId stale = scene.add_node(scene.root());
  scene.remove_node(stale);
  const core::NodeId mixed[] = {nodes[0], stale};
  EXPECT_FALSE(engine->isolate(mixed));
  EXPECT_FALSE(engine->isolate({{core::NodeId{1000, 0}}}));
  const ItemId good{3};
  for (const float bad : {-0.1f, 1.1f, std::numeric_limits<float>::quiet_NaN()}) {
    EXPECT_FALSE(engine->set_override({&good, 1}, {.alpha = bad}));
    EXPECT_FALSE(engine->set_override({&good, 1}, {.colour = core::vec3(0, bad, 0)}));
  }
  expect_same(*engine, *plain, around(1));
  EXPECT_EQ(engine->memory().snapshot, plain->memory().snapshot);
}

TEST_F(OverridesTest, CostNothingAfterTheLastIsCleared) {
  auto engine = Engine::create(scene, configured(CullerChoice::kCpu)),
       plain = Engine::create(twin, configured(CullerChoice::kCpu));
  ASSERT_TRUE(engine && plain);
  const std::size_t before = engine->memory().snapshot;
  std::vector<ItemId> all(to_index(items));
  for (ItemId item{0}; item < items; ++item) all[to_index(item)] = item;
  ASSERT_TRUE(engine->set_override(all, {.alpha = 0.5f}) && engine->hide(all));
  EXPECT_GT(engine->memory().snapshot, before);
  EXPECT_TRUE(engine->items_in(around(0), {0, 0, 192, 128}, culling::RegionRule::kCrossing)->empty());
  ASSERT_TRUE(engine->clear_overrides() && engine->show_all());
  EXPECT_LT(engine->memory().snapshot, before + 4096) << "some rows of the table";
  expect_same(*engine, *plain, around(0));
}

}  // namespace
}  // namespace sightline::tests::overrides_test
