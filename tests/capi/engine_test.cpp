// Engines without GL: counts, visible items, picks and regions are those of C++.
#include "sightline/engine/engine.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <glm/gtc/type_ptr.hpp>

#include "c_scene.h"
#if __has_include("sightline/raytrace/tracer.h")
#include "sightline/engine/pick.h"
#endif

namespace sightline::tests::engine_test {
namespace {

constexpr int kGrid = 8;

/// A grid with an engine in both APIs.
class CapiEngine : public ::testing::Test {
 protected:
  void SetUp() override {
    fill_grid(c, scene, kGrid);
    sl_engine_config config = SL_ENGINE_CONFIG_INIT;
    config.width = 300, config.height = 200;
    ASSERT_OK(sl_engine_create(c.scene, &config, &engine));
    engine::EngineConfig same;
    same.width = 300, same.height = 200;
    auto made = engine::Engine::create(scene, same);
    ASSERT_TRUE(made);
    twin.emplace(std::move(*made));
  }
  void TearDown() override {
    if (engine.id) {
      EXPECT_OK(sl_engine_destroy(engine));
    }
  }

  std::vector<core::ItemId> visible_in_cpp() const {
    std::vector<core::ItemId> items;
    twin->visible().for_each_slot([&](core::Slot slot) {
      if (!twin->snapshot().vacant(slot)) items.push_back(twin->snapshot().item(slot));
    });
    std::sort(items.begin(), items.end());
    return items;
  }

  void compare_frame(const BothViews& view) {
    sl_frame_report report = SL_FRAME_REPORT_INIT;
    ASSERT_OK(sl_engine_frame(engine, &view.c, nullptr, &report));
    const auto expected = twin->frame(view.cpp);
    ASSERT_TRUE(expected);
    EXPECT_EQ(report.visible, expected->visible);
    EXPECT_EQ(report.tested, expected->tested);
    EXPECT_EQ(report.frame, expected->frame);
    EXPECT_EQ(report.culler, sl_culler(expected->culler));
    EXPECT_EQ(report.shown, -1);
    EXPECT_EQ(report.hybrid_state, -1);
    EXPECT_EQ(report.drawn, 0);
    std::vector<sl_item> items(kGrid * kGrid * kGrid + 1);
    std::size_t count = 0;
    ASSERT_OK(sl_engine_visible(engine, items.data(), items.size(), &count));
    ASSERT_EQ(count, std::size_t(report.visible));
    items.resize(count);
    std::sort(items.begin(), items.end());
    EXPECT_EQ(items, visible_in_cpp());
  }

  CScene c;
  core::Scene scene;
  sl_engine engine = {0};
  std::optional<engine::Engine> twin;
};

TEST_F(CapiEngine, CullsAsCppDoes) {
  for (int i = 0; i < 20; ++i) {
    const double turn = 0.4 * i;
    compare_frame(BothViews({7 + 12 * std::cos(turn), 7 + 12 * std::sin(turn), 9}, {7, 7, 7}));
  }
}

TEST_F(CapiEngine, ShowsEditsAfterCommit) {
  const BothViews view({7, -20, 7}, {7, 7, 7});
  compare_frame(view);
  for (sl_item item = 0; item < 500; item += 3) {
    ASSERT_OK(sl_item_set_placement(c.scene, item, translation(0, 1000, item).m));
    scene.set_placement(item, core::translation({0, 1000, item}));
  }
  for (sl_item item = 1; item < 500; item += 3) {
    ASSERT_OK(sl_item_remove(c.scene, item));
    scene.remove_item(item);
  }
  compare_frame(view);
  ASSERT_OK(sl_engine_commit(engine));
  ASSERT_TRUE(twin->commit());
  compare_frame(view);
  ASSERT_OK(sl_engine_rebuild(engine));
  ASSERT_TRUE(twin->rebuild());
  std::size_t count = 0;
  EXPECT_EQ(sl_engine_visible(engine, nullptr, 0, &count), SL_ERROR_BUSY) << "the last frame had another order";
  compare_frame(view);
}

TEST_F(CapiEngine, CullersAreChosen) {
  const BothViews view({7, -20, 7}, {7, 7, 7});
  sl_engine_info info = SL_ENGINE_INFO_INIT;
  for (const sl_culler culler : {SL_CULLER_LINEAR, SL_CULLER_CPU, SL_CULLER_AUTOMATIC}) {
    ASSERT_OK(sl_engine_set_culler(engine, culler));
    ASSERT_TRUE(twin->set_culler(engine::CullerChoice(culler)));
    ASSERT_OK(sl_engine_get(engine, &info));
    EXPECT_EQ(info.culler, sl_culler(twin->plan().culler));
    compare_frame(view);
  }
  EXPECT_EQ(info.snapshot_bytes, twin->memory().snapshot);
  EXPECT_EQ(info.hierarchy_bytes, twin->memory().bvh);
  EXPECT_GT(info.scene_bytes, 512u * 100u);
  EXPECT_EQ(sl_engine_set_culler(engine, 5), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_engine_set_culler(engine, -1), SL_ERROR_ARGUMENT);
}

TEST_F(CapiEngine, CullsAnotherViewThanItShows) {
  const BothViews view({7, -20, 7}, {7, 7, 7}), aside({7, -20, 7}, {7, -40, 7});
  sl_frame_report report = SL_FRAME_REPORT_INIT;
  ASSERT_OK(sl_engine_frame(engine, &view.c, &aside.c, &report));
  EXPECT_EQ(report.visible, 0);
  ASSERT_OK(sl_engine_frame(engine, &aside.c, &view.c, &report));
  EXPECT_GT(report.visible, 100);
}

TEST_F(CapiEngine, BadArgumentsAreErrors) {
  const BothViews view({7, -20, 7}, {7, 7, 7});
  EXPECT_EQ(sl_engine_frame(engine, nullptr, nullptr, nullptr), SL_ERROR_ARGUMENT);
  sl_view bad = view.c;
  bad.clip_from_eye[3] = std::nan("");
  EXPECT_EQ(sl_engine_frame(engine, &bad, nullptr, nullptr), SL_ERROR_FAILED);
  bad = view.c;
  bad.size = 8;
  EXPECT_EQ(sl_engine_frame(engine, &bad, nullptr, nullptr), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_engine_resize(engine, 0, 10), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_engine_resize(engine, 10, 70'000), SL_ERROR_ARGUMENT);
  EXPECT_NE(sl_engine_read_colour(engine, nullptr, 0), SL_OK);
  sl_engine_config config = SL_ENGINE_CONFIG_INIT;
  sl_engine other = {5};
  config.contribution = -1;
  EXPECT_EQ(sl_engine_create(c.scene, &config, &other), SL_ERROR_FAILED);
  config = SL_ENGINE_CONFIG_INIT;
  config.occlusion = 3;
  EXPECT_EQ(sl_engine_create(c.scene, &config, &other), SL_ERROR_ARGUMENT);
  config = SL_ENGINE_CONFIG_INIT;
  config.width = -5;
  EXPECT_EQ(sl_engine_create(c.scene, &config, &other), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_engine_create(c.scene, nullptr, nullptr), SL_ERROR_ARGUMENT);
  EXPECT_EQ(other.id, 5u);
}

TEST_F(CapiEngine, RegionsAreThoseOfCpp) {
  const BothViews view({7, -20, 7}, {7, 7, 7});
  const double rectangle[4] = {100, 50, 220, 160};
  std::vector<sl_item> items(kGrid * kGrid * kGrid);
  std::size_t count = 0;
  for (const std::int32_t rule : {SL_REGION_CROSSING, SL_REGION_WHOLLY}) {
    items.resize(kGrid * kGrid * kGrid);
    ASSERT_OK(sl_engine_items_in(engine, &view.c, rectangle, rule, items.data(), items.size(), &count));
    items.resize(count);
    EXPECT_EQ(items, *twin->items_in(view.cpp, {100, 50, 220, 160}, culling::RegionRule(rule)));
    EXPECT_GT(count, 10u);
    items.resize(kGrid * kGrid * kGrid);
    const sl_plane planes[2] = {{{1, 0, 0}, -3}, {{0, -1, 0.5}, 6}};
    ASSERT_OK(
        sl_engine_items_in_planes(engine, planes, 2, rule, SL_DEFAULT_LAYERS, items.data(), items.size(), &count));
    items.resize(count);
    EXPECT_EQ(items, *twin->items_in({{{1, 0, 0}, -3}, {{0, -1, 0.5}, 6}}, culling::RegionRule(rule)));
    EXPECT_GT(count, 10u);
  }
  EXPECT_EQ(sl_engine_items_in(engine, &view.c, rectangle, 2, nullptr, 0, &count), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_engine_items_in(engine, &view.c, nullptr, 0, nullptr, 0, &count), SL_ERROR_ARGUMENT);
  const sl_plane many[9] = {};
  EXPECT_EQ(sl_engine_items_in_planes(engine, many, 9, 0, 1, nullptr, 0, &count), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_engine_items_in_planes(engine, nullptr, 1, 0, 1, nullptr, 0, &count), SL_ERROR_ARGUMENT);
}

#if __has_include("sightline/raytrace/tracer.h")

void expect_same(const sl_pick& pick, const std::optional<engine::Pick>& expected) {
  if (!expected) {
    EXPECT_EQ(pick.item, SL_NO_ITEM);
    return;
  }
  EXPECT_EQ(pick.item, expected->item);
  EXPECT_NE(pick.node.id, 0u);
  EXPECT_EQ(pick.t, expected->t);
  EXPECT_EQ(glm::make_vec3(pick.point), expected->point);
  EXPECT_EQ(glm::make_vec3(pick.normal), expected->normal);
  EXPECT_EQ(pick.triangle, expected->triangle);
  EXPECT_EQ(pick.face, std::int32_t(expected->face));
}

TEST_F(CapiEngine, PicksWhatCppPicks) {
  BothViews view({7, -12, 7}, {7, 7, 7});
  view.c.section_count = 1;
  view.c.sections[0] = {{0, 1, 0.3}, -4};
  view.cpp.sections = {{{0, 1, 0.3}, -4}};
  int hits = 0;
  for (int y = 5; y < 200; y += 15)
    for (int x = 5; x < 300; x += 15) {
      sl_pick pick = SL_PICK_INIT;
      ASSERT_OK(sl_engine_pick(engine, &view.c, x, y, &pick));
      const auto expected = twin->pick(view.cpp, x, y);
      ASSERT_TRUE(expected);
      expect_same(pick, *expected);
      hits += pick.item != SL_NO_ITEM;
    }
  EXPECT_GT(hits, 50);
  EXPECT_LT(hits, 200);
}

TEST_F(CapiEngine, PicksAlongRays) {
  sl_ray ray = SL_RAY_INIT;
  ray.origin[0] = 6, ray.origin[1] = -10, ray.origin[2] = 0.1;
  sl_pick pick = SL_PICK_INIT;
  ASSERT_OK(sl_engine_pick_ray(engine, &ray, &pick));
  const auto expected = twin->pick(raytrace::Ray{{6, -10, 0.1}, {0, 1, 0}});
  ASSERT_TRUE(expected && *expected);
  expect_same(pick, *expected);
  ray.layers = 0;
  ASSERT_OK(sl_engine_pick_ray(engine, &ray, &pick));
  EXPECT_EQ(pick.item, SL_NO_ITEM);
  ray.direction[1] = 0;
  EXPECT_EQ(sl_engine_pick_ray(engine, &ray, &pick), SL_ERROR_FAILED) << "no direction";
  ray.direction[1] = 1e200;
  EXPECT_EQ(sl_engine_pick_ray(engine, &ray, &pick), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_engine_pick_ray(engine, nullptr, &pick), SL_ERROR_ARGUMENT);
}

TEST_F(CapiEngine, ThePickedNodeIsThatOfTheLastCommit) {
  const CScene one;
  const sl_node node = one.add_node(one.root);
  one.add(node, SL_SPHERE);
  sl_engine picking = {0};
  ASSERT_OK(sl_engine_create(one.scene, nullptr, &picking));
  sl_ray ray = SL_RAY_INIT;
  ray.origin[1] = -10;
  sl_pick pick = SL_PICK_INIT;
  ASSERT_OK(sl_engine_pick_ray(picking, &ray, &pick));
  EXPECT_EQ(pick.node.id, node.id);
  ASSERT_OK(sl_node_remove(one.scene, node));
  ASSERT_OK(sl_engine_pick_ray(picking, &ray, &pick));
  EXPECT_EQ(pick.item, 0u) << "until the next commit";
  EXPECT_EQ(pick.node.id, node.id);
  ASSERT_OK(sl_engine_commit(picking));
  ASSERT_OK(sl_engine_pick_ray(picking, &ray, &pick));
  EXPECT_EQ(pick.item, SL_NO_ITEM);
  EXPECT_OK(sl_engine_destroy(picking));
}

TEST_F(CapiEngine, ExactlyVisibleItemsAreThoseOfCpp) {
  const BothViews view({7, -12, 7}, {7, 7, 7});
  const double rectangle[4] = {100, 50, 180, 120};
  std::vector<sl_visible_item> items(kGrid * kGrid * kGrid);
  std::size_t count = 0;
  ASSERT_OK(sl_engine_visible_items_in(engine, &view.c, rectangle, 2, items.data(), items.size(), &count));
  const auto expected = twin->visible_items_in(view.cpp, {100, 50, 180, 120}, 2);
  ASSERT_TRUE(expected);
  ASSERT_EQ(count, expected->size());
  EXPECT_GT(count, 5u);
  for (std::size_t i = 0; i < count; ++i) {
    EXPECT_EQ(items[i].item, (*expected)[i].item);
    EXPECT_EQ(items[i].samples, (*expected)[i].samples);
  }
  EXPECT_EQ(sl_engine_visible_items_in(engine, &view.c, rectangle, 0, nullptr, 0, &count), SL_ERROR_ARGUMENT);
}

#endif

TEST_F(CapiEngine, HidesAndIsolatesAsCppDoes) {
  const BothViews view({7, -20, 7}, {7, 7, 7});
  const std::vector<sl_item> some = {3, 5, 200, 201, 202}, unknown = {1, 100'000};
  ASSERT_OK(sl_engine_set_hidden(engine, some.data(), some.size(), 1));
  ASSERT_TRUE(twin->hide(some));
  compare_frame(view);
  ASSERT_OK(sl_engine_set_hidden(engine, some.data(), 2, 0));
  ASSERT_TRUE(twin->show(std::span(some).first(2)));
  compare_frame(view);
  const std::size_t before = visible_in_cpp().size();
  const sl_node node = c.add_node(c.root);
  c.add(node, SL_SPHERE);
  const core::NodeId same = scene.add_node(scene.root());
  scene.add_primitive(same, core::Sphere{0.9f});
  ASSERT_OK(sl_engine_commit(engine));
  ASSERT_TRUE(twin->commit());
  ASSERT_OK(sl_engine_isolate(engine, &node, 1));
  ASSERT_TRUE(twin->isolate(std::vector{same}));
  compare_frame(view);
  EXPECT_EQ(visible_in_cpp().size(), 1u);
  ASSERT_OK(sl_engine_show_all(engine));
  ASSERT_TRUE(twin->show_all());
  compare_frame(view);
  EXPECT_GT(visible_in_cpp().size(), before);
  EXPECT_EQ(sl_engine_set_hidden(engine, unknown.data(), 2, 1), SL_ERROR_FAILED);
  EXPECT_EQ(sl_engine_set_hidden(engine, nullptr, 2, 1), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_engine_isolate(engine, nullptr, 1), SL_ERROR_ARGUMENT);
  ASSERT_OK(sl_node_remove(c.scene, node));
  EXPECT_EQ(sl_engine_isolate(engine, &node, 1), SL_ERROR_HANDLE);
  sl_item_style style = SL_ITEM_STYLE_INIT;
  style.alpha = 2;
  EXPECT_EQ(sl_engine_set_override(engine, some.data(), 1, &style), SL_ERROR_FAILED);
  EXPECT_EQ(sl_engine_set_override(engine, some.data(), 1, nullptr), SL_ERROR_ARGUMENT);
}

TEST_F(CapiEngine, SaysWhatItUses) {
  char lines[4096];
  sl_text text = {lines, sizeof lines, 0};
  ASSERT_OK(sl_engine_explain(engine, &text));
  const std::string all(lines);
  EXPECT_EQ(all.size(), text.length);
  EXPECT_NE(all.find("renderer: none\n"), std::string::npos) << all;
  for (const engine::PlanEntry& entry : twin->plan().entries)
    EXPECT_NE(all.find(entry.feature + (entry.used ? ": used: " : ": left out: ") + entry.why), std::string::npos);
}

TEST_F(CapiEngine, TwoEnginesFollowOneScene) {
  sl_engine second = {0};
  ASSERT_OK(sl_engine_create(c.scene, nullptr, &second));
  c.add(c.root, SL_SPHERE, translation(0, -5, 0));
  ASSERT_OK(sl_engine_commit(engine));
  const BothViews view({0, -8, 0}, {0, -6, 0});
  const auto visible = [&](sl_engine of) {
    sl_frame_report report = SL_FRAME_REPORT_INIT;
    EXPECT_OK(sl_engine_frame(of, &view.c, nullptr, &report));
    return report.visible;
  };
  EXPECT_EQ(visible(engine), visible(second) + 1);
  ASSERT_OK(sl_engine_commit(second));
  EXPECT_EQ(visible(engine), visible(second));
  EXPECT_OK(sl_engine_destroy(second));
}

}  // namespace
}  // namespace sightline::tests::engine_test
