// Engines without GL: counts, visible items, picks and regions are those of C++.
#include "sightline/engine/engine.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

#include <glm/gtc/type_ptr.hpp>

#include "each_setting.h"
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
    EXPECT_EQ(report.items_drawn, -1);
    EXPECT_EQ(report.hybrid_state, -1);
    EXPECT_EQ(report.drawn, 0);
    std::vector<sl_item> items(kGrid * kGrid * kGrid + 1);
    std::size_t count = 0;
    ASSERT_OK(sl_engine_visible(engine, items.data(), items.size(), &count));
    ASSERT_EQ(count, std::size_t(report.visible));
    items.resize(count);
    std::sort(items.begin(), items.end());
    EXPECT_EQ(items, c_ids(visible_in_cpp()));
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
    scene.set_placement(core::ItemId(item), core::translation({0, 1000, item}));
  }
  for (sl_item item = 1; item < 500; item += 3) {
    ASSERT_OK(sl_item_remove(c.scene, item));
    scene.remove_item(core::ItemId(item));
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
  for (const sl_culler culler : {SL_CULLER_LINEAR, SL_CULLER_CPU, SL_CULLER_AUTO}) {
    ASSERT_OK(sl_engine_set_culler(engine, culler));
    ASSERT_TRUE(twin->set_culler(engine::CullerChoice(culler)));
    ASSERT_OK(sl_engine_get(engine, &info));
    EXPECT_EQ(info.culler, sl_culler(twin->plan().culler));
    compare_frame(view);
  }
  ASSERT_OK(sl_engine_get(engine, &info));
  EXPECT_EQ(info.snapshot_bytes, twin->memory().snapshot);
  EXPECT_EQ(info.hierarchy_bytes, twin->memory().bvh);
  EXPECT_EQ(info.scratch_bytes, twin->memory().scratch);
  EXPECT_EQ(info.levels_bytes, twin->memory().levels);
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
  config.losses.min_projected_area = -1;
  EXPECT_EQ(sl_engine_create(c.scene, &config, &other), SL_ERROR_FAILED);
  config = SL_ENGINE_CONFIG_INIT;
  config.culling.occlusion = 3;
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
    EXPECT_EQ(items, c_ids(*twin->items_in(view.cpp, {100, 50, 220, 160}, culling::RegionRule(rule))));
    EXPECT_GT(count, 10u);
    items.resize(kGrid * kGrid * kGrid);
    const sl_plane planes[2] = {{{1, 0, 0}, -3}, {{0, -1, 0.5}, 6}};
    ASSERT_OK(
        sl_engine_items_in_planes(engine, planes, 2, rule, SL_DEFAULT_LAYERS, items.data(), items.size(), &count));
    items.resize(count);
    EXPECT_EQ(items, c_ids(*twin->items_in({{{1, 0, 0}, -3}, {{0, -1, 0.5}, 6}}, culling::RegionRule(rule))));
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
  EXPECT_EQ(pick.item, to_index(expected->item));
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

/// A style for one item in both APIs.
void make_ghost(sl_engine engine, engine::Engine& twin, sl_item item) {
  sl_item_style style = SL_ITEM_STYLE_INIT;
  style.ghost = 1;
  ASSERT_OK(sl_engine_set_override(engine, &item, 1, &style));
  ASSERT_TRUE(twin.set_override(cpp_ids({&item, 1}), {.ghost = true}));
}

TEST_F(CapiEngine, GhostsAreHitOnRequest) {
  const BothViews view({7, -12, 7}, {7, 7, 7});
  sl_pick solid = SL_PICK_INIT, pick = SL_PICK_INIT;
  int found = 0;
  for (int x = 5; x < 300; x += 15) {
    ASSERT_OK(sl_engine_pick(engine, &view.c, x, 80, &solid));
    if (solid.item == SL_NO_ITEM) continue;
    ++found;
    make_ghost(engine, *twin, solid.item);
    ASSERT_OK(sl_engine_pick(engine, &view.c, x, 80, &pick));
    EXPECT_NE(pick.item, solid.item);
    expect_same(pick, *twin->pick(view.cpp, x, 80));
    ASSERT_OK(sl_engine_pick_ghosts(engine, &view.c, x, 80, &pick));
    EXPECT_EQ(pick.item, solid.item);
    EXPECT_EQ(pick.t, solid.t);
    ASSERT_OK(sl_engine_clear_override(engine, nullptr, 0));
    ASSERT_TRUE(twin->clear_overrides());
  }
  EXPECT_GT(found, 5);
  sl_ray ray = SL_RAY_INIT;
  ray.origin[0] = 6, ray.origin[1] = -10, ray.origin[2] = 0.1;
  ASSERT_OK(sl_engine_pick_ray(engine, &ray, &solid));
  make_ghost(engine, *twin, solid.item);
  ASSERT_OK(sl_engine_pick_ray(engine, &ray, &pick));
  EXPECT_NE(pick.item, solid.item);
  ray.hit_ghosts = 1;
  ASSERT_OK(sl_engine_pick_ray(engine, &ray, &pick));
  EXPECT_EQ(pick.item, solid.item);
}

TEST_F(CapiEngine, SectionsCutWhatRaysHit) {
  sl_ray ray = SL_RAY_INIT;
  ray.origin[0] = 2, ray.origin[1] = -10, ray.origin[2] = 0.1;  // along a row of items
  ray.section_count = 2;
  ray.section_mode = SL_SECTIONS_INTERSECTION;
  ray.sections[0] = {{0, 1, 0}, -4.1};  // keeps what lies beyond y = 4.1
  ray.sections[1] = {{1, 0, 0}, 100};
  raytrace::RayFilter filter;
  filter.sections = {{{0, 1, 0}, -4.1}, {{1, 0, 0}, 100}};
  std::vector<double> distances;
  for (const bool cuts : {true, false}) {
    ray.leave_out_cuts = !cuts;
    filter.cuts = cuts;
    sl_pick pick = SL_PICK_INIT;
    ASSERT_OK(sl_engine_pick_ray(engine, &ray, &pick));
    expect_same(pick, *twin->pick(core::Ray{{2, -10, 0.1}, {0, 1, 0}}, filter));
    EXPECT_GE(pick.point[1], 4.1 - 1e-9);
    EXPECT_EQ(pick.face == std::int32_t(core::Face::kCut), cuts);
    distances.push_back(pick.t);
  }
  EXPECT_LT(distances[0], distances[1]);
  sl_pick pick = SL_PICK_INIT;
  ray.section_mode = SL_SECTIONS_UNION;  // the second plane keeps everything
  ASSERT_OK(sl_engine_pick_ray(engine, &ray, &pick));
  EXPECT_LT(pick.point[1], 4.0);
  ray.section_mode = 2;
  EXPECT_EQ(sl_engine_pick_ray(engine, &ray, &pick), SL_ERROR_ARGUMENT);
  ray.section_mode = 0, ray.section_count = SL_MAX_SECTIONS + 1;
  EXPECT_EQ(sl_engine_pick_ray(engine, &ray, &pick), SL_ERROR_ARGUMENT);
}

TEST_F(CapiEngine, TheTracerIsMadeAhead) {
  sl_engine_info info = SL_ENGINE_INFO_INIT;
  ASSERT_OK(sl_engine_get(engine, &info));
  EXPECT_EQ(info.preparing_picks, 0);
  EXPECT_EQ(info.tracer_bytes, 0u);
  ASSERT_OK(sl_engine_prepare_picks(engine));
  do {
    ASSERT_OK(sl_engine_get(engine, &info));
  } while (info.preparing_picks);
  const BothViews view({7, -12, 7}, {7, 7, 7});
  sl_pick pick = SL_PICK_INIT;
  ASSERT_OK(sl_engine_pick(engine, &view.c, 140, 80, &pick));
  expect_same(pick, *twin->pick(view.cpp, 140, 80));
  ASSERT_OK(sl_engine_get(engine, &info));
  EXPECT_GT(info.tracer_bytes, 0u);
}

TEST_F(CapiEngine, PicksAlongRays) {
  sl_ray ray = SL_RAY_INIT;
  ray.origin[0] = 6, ray.origin[1] = -10, ray.origin[2] = 0.1;
  sl_pick pick = SL_PICK_INIT;
  ASSERT_OK(sl_engine_pick_ray(engine, &ray, &pick));
  const auto expected = twin->pick(core::Ray{{6, -10, 0.1}, {0, 1, 0}});
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
    EXPECT_EQ(items[i].item, to_index((*expected)[i].item));
    EXPECT_EQ(items[i].samples, (*expected)[i].samples);
  }
  EXPECT_EQ(sl_engine_visible_items_in(engine, &view.c, rectangle, 0, nullptr, 0, &count), SL_ERROR_ARGUMENT);
}

#endif

TEST_F(CapiEngine, HidesAndIsolatesAsCppDoes) {
  const BothViews view({7, -20, 7}, {7, 7, 7});
  const std::vector<sl_item> some = {3, 5, 200, 201, 202}, unknown = {1, 100'000};
  ASSERT_OK(sl_engine_set_hidden(engine, some.data(), some.size(), 1));
  ASSERT_TRUE(twin->hide(cpp_ids(some)));
  compare_frame(view);
  ASSERT_OK(sl_engine_set_hidden(engine, some.data(), 2, 0));
  ASSERT_TRUE(twin->show(cpp_ids(std::span(some).first(2))));
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
  std::vector<sl_item> told(2000);
  std::size_t count = 0;
  ASSERT_OK(sl_engine_hidden_items(engine, told.data(), told.size(), &count));
  EXPECT_EQ(std::vector(told.begin(), told.begin() + std::ptrdiff_t(count)), c_ids(twin->hidden_items()));
  ASSERT_OK(sl_engine_hidden_items(engine, told.data(), 3, &count));
  EXPECT_EQ(count, twin->hidden_items().size()) << "of all, also without room";
  for (const sl_item item : {sl_item(3), to_index(twin->items_below(std::vector{same})->front())}) {
    std::int32_t hidden = -1;
    ASSERT_OK(sl_engine_is_hidden(engine, item, &hidden));
    EXPECT_EQ(hidden != 0, twin->is_hidden(core::ItemId{item}));
  }
  for (const sl_item missing : {sl_item(100'000), SL_NO_ITEM}) {
    std::int32_t answer = -1;
    sl_item_style style = SL_ITEM_STYLE_INIT;
    EXPECT_EQ(sl_engine_is_hidden(engine, missing, &answer), SL_ERROR_FAILED);
    EXPECT_EQ(sl_engine_get_override(engine, missing, &answer, &style), SL_ERROR_FAILED);
    EXPECT_NE(std::string(sl_last_error()).find("no item " + std::to_string(missing)), std::string::npos);
    EXPECT_EQ(answer, -1);
  }
  ASSERT_OK(sl_engine_items_below(engine, &node, 1, told.data(), told.size(), &count));
  ASSERT_EQ(count, 1u);
  EXPECT_EQ(told[0], to_index(twin->items_below(std::vector{same})->front()));
  EXPECT_EQ(sl_engine_items_below(engine, nullptr, 1, told.data(), 1, &count), SL_ERROR_ARGUMENT);
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
  sl_item_style style = SL_ITEM_STYLE_INIT, found = SL_ITEM_STYLE_INIT;
  std::int32_t there = -1;
  style.use_colour = 1, style.colour[1] = 0.5f, style.alpha = 0.25f, style.ghost = 1;
  ASSERT_OK(sl_engine_set_override(engine, &some[1], 2, &style));
  ASSERT_OK(sl_engine_get_override(engine, some[2], &there, &found));
  EXPECT_EQ(there, 1);
  EXPECT_EQ(std::memcmp(&found, &style, sizeof(style)), 0);
  ASSERT_OK(sl_engine_get_override(engine, some[0], &there, &found));
  EXPECT_EQ(there, 0);
  EXPECT_EQ(found.alpha, 1.0f);
  ASSERT_OK(sl_engine_overridden_items(engine, told.data(), told.size(), &count));
  EXPECT_EQ(std::vector(told.begin(), told.begin() + std::ptrdiff_t(count)), (std::vector{some[1], some[2]}));
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

// --- settings --------------------------------------------------------------------------------------------------------

/// Settings of which none is the default, where that needs no GL.
sl_engine_config other_settings() {
  sl_engine_config c = SL_ENGINE_CONFIG_INIT;
  c.width = 300, c.height = 200, c.threads = 3;
  c.culling.culler = SL_CULLER_LINEAR, c.culling.gpu_variant = SL_GPU_VARIANT_COMPUTE;
  c.culling.sample_test = 0, c.culling.occlusion = SL_OCCLUSION_OFF;
  c.culling.part = {1, 3}, c.culling.rebuild_share = 0.25;
  c.culling.controller = {0.5, 0.25, 0.75, 9, 0.125, 3, 0.0625, 201, 17, 0.375};
  c.drawing.renderer = SL_RENDERER_AUTO, c.drawing.ids = 1, c.drawing.samples = 4;
  c.drawing.transparency = SL_TRANSPARENCY_BLENDED;
  c.drawing.outline_colour[1] = 0.125f, c.drawing.culled_colour = {1, {0.0f, 0.0f, 0.75f}};
  sl_looks& looks = c.drawing.looks;
  looks.depth_shading = {0.5f, 0.25f}, looks.hatching = {0.75f, 9.0f};
  looks.edges = {SL_EDGES_ALL, 2.5f, {0.25f, 0.5f, 0.75f}};
  looks.lighting = SL_LIGHTING_SUN, looks.sun[0] = 0.5;
  looks.background.bottom[1] = 0.25f, looks.background.top[2] = 1.0f;
  c.losses = {2.5f, SL_CONTRIBUTION_POINTS, 7.0, 1.5};
  c.context.later = 1, c.context.gl_state = SL_GL_STATE_LEAVE, c.context.platform = SL_CONTEXT_OSMESA;
  c.context.gl_debug = 1;
  return c;
}

TEST_F(CapiEngine, SettingsComeBack) {
  const sl_engine_config others = other_settings(), defaults = SL_ENGINE_CONFIG_INIT;
  for_each_setting(others, defaults, [](const std::string& name, const auto& one, const auto& other) {
    EXPECT_EQ(same_setting(one, other), name == "draw" || name == "program_cache") << name;
  });
  for (const sl_engine_config* chosen : {&others, &defaults}) {
    sl_engine other = {0};
    ASSERT_OK(sl_engine_create(c.scene, chosen, &other));
    sl_engine_config config = SL_ENGINE_CONFIG_INIT;
    ASSERT_OK(sl_engine_get_config(other, &config));
    compare_settings(config, *chosen);
    EXPECT_OK(sl_engine_configure(other, &config)) << "they are as they are";
    EXPECT_OK(sl_engine_destroy(other));
  }
}

TEST_F(CapiEngine, DefaultsAreThoseOfCpp) {
  compare_settings(sl_engine_config SL_ENGINE_CONFIG_INIT, engine::EngineConfig());
}

TEST_F(CapiEngine, SettingsChangeWhileItLives) {
  const BothViews view({7, -20, 7}, {7, 7, 7});
  sl_engine_config config = SL_ENGINE_CONFIG_INIT;
  ASSERT_OK(sl_engine_get_config(engine, &config));
  config.losses.budget_ms = 12.0;
  config.culling.culler = SL_CULLER_LINEAR;
  ASSERT_OK(sl_engine_configure(engine, &config));
  sl_engine_config now = SL_ENGINE_CONFIG_INIT;
  ASSERT_OK(sl_engine_get_config(engine, &now));
  EXPECT_EQ(now.losses.budget_ms, 12.0);
  ASSERT_TRUE(twin->set_culler(engine::CullerChoice::kLinear));
  compare_frame(view);
  const auto refused = [&](const char* why, auto change) {
    sl_engine_config changed = now;
    change(changed);
    EXPECT_EQ(sl_engine_configure(engine, &changed), SL_ERROR_FAILED) << why;
    EXPECT_NE(std::strstr(sl_last_error(), why), nullptr) << sl_last_error();
    sl_engine_config after = SL_ENGINE_CONFIG_INIT;
    EXPECT_OK(sl_engine_get_config(engine, &after));
    compare_settings(after, now);
  };
  refused("size", [](sl_engine_config& bad) { ++bad.width; });
  refused("ids", [](sl_engine_config& bad) { bad.drawing.ids = 1; });
  refused("part", [](sl_engine_config& bad) { bad.culling.part.count = 2; });
  refused("transparency", [](sl_engine_config& bad) { bad.drawing.transparency = SL_TRANSPARENCY_BLENDED; });
  refused("edge_lines must be 0 to 1",
          [](sl_engine_config& bad) { bad.drawing.looks.depth_shading.edge_lines = 1.5f; });
  refused("sun must be", [](sl_engine_config& bad) { bad.drawing.looks.sun[2] = 0.0; });
  refused("background_top must be", [](sl_engine_config& bad) { bad.drawing.looks.background.top[0] = 1.5f; });
  refused("hatching_spacing must be 2 or more pixels",
          [](sl_engine_config& bad) { bad.drawing.looks.hatching.spacing = 1.0f; });
  config.drawing.transparency = 2;
  EXPECT_EQ(sl_engine_configure(engine, &config), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_engine_configure(engine, nullptr), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_engine_get_config(engine, nullptr), SL_ERROR_ARGUMENT);
}

TEST_F(CapiEngine, ControllersAreChecked) {
  const auto refused = [&](const char* why, auto change) {
    sl_engine_config config = SL_ENGINE_CONFIG_INIT;
    change(config.culling.controller);
    sl_engine other = {5};
    EXPECT_EQ(sl_engine_create(c.scene, &config, &other), SL_ERROR_ARGUMENT) << why;
    EXPECT_NE(std::strstr(sl_last_error(), why), nullptr) << sl_last_error();
    EXPECT_EQ(other.id, 5u);
  };
  refused("margin to be 0 or more", [](sl_controller_config& k) { k.margin = std::nan(""); });
  refused("probe_cost to be 0 or more", [](sl_controller_config& k) { k.probe_cost = HUGE_VAL; });
  refused("probe_share to be 0 or more", [](sl_controller_config& k) { k.probe_share = -1.0; });
  sl_controller_info info = SL_CONTROLLER_INFO_INIT;
  ASSERT_OK(sl_engine_get_controller(engine, &info));
  EXPECT_EQ(info.there, 0) << "no hybrid";
}

// --- creation --------------------------------------------------------------------------------------------------------

struct Told {
  sl_scene scene;
  double last = -1.0, stop_at = 2.0;  // shares
  int calls = 0;
  static std::int32_t progress(double share, void* user) {
    Told& told = *static_cast<Told*>(user);
    EXPECT_GE(share, told.last);
    EXPECT_EQ(sl_scene_commit(told.scene), SL_ERROR_BUSY);
    told.last = share;
    ++told.calls;
    return share < told.stop_at;
  }
};

TEST_F(CapiEngine, CreationTellsItsProgressAndStops) {
  const BothViews view({7, -20, 7}, {7, 7, 7});
  Told told{c.scene};
  sl_engine_config config = SL_ENGINE_CONFIG_INIT;
  config.progress = Told::progress, config.progress_user = &told;
  sl_engine other = {0};
  ASSERT_OK(sl_engine_create(c.scene, &config, &other));
  EXPECT_EQ(told.last, 1.0);
  EXPECT_GE(told.calls, 2);
  EXPECT_OK(sl_engine_destroy(other));
  told = {c.scene};
  told.stop_at = 0.0;
  other = {7};
  EXPECT_EQ(sl_engine_create(c.scene, &config, &other), SL_ERROR_CANCELLED);
  EXPECT_EQ(other.id, 7u);
  EXPECT_EQ(told.calls, 1);
  c.add(c.root, SL_SPHERE, translation(7, -15, 7));
  ASSERT_OK(sl_engine_create(c.scene, nullptr, &other)) << "the scene still serves";
  sl_frame_report report = SL_FRAME_REPORT_INIT;
  ASSERT_OK(sl_engine_frame(other, &view.c, nullptr, &report));
  EXPECT_EQ(report.visible, twin->frame(view.cpp)->visible + 1);
  EXPECT_OK(sl_engine_destroy(other));
}

TEST_F(CapiEngine, AThrowingProgressCancels) {
  sl_engine_config config = SL_ENGINE_CONFIG_INIT;
  config.progress = [](double, void*) -> std::int32_t { throw 1; };
  sl_engine other = {0};
  EXPECT_EQ(sl_engine_create(c.scene, &config, &other), SL_ERROR_CANCELLED);
  EXPECT_OK(sl_scene_commit(c.scene));
}

TEST_F(CapiEngine, PartsAreTogetherTheScene) {
  const BothViews view({7, -20, 7}, {7, 7, 7});
  std::vector<sl_item> all;
  for (int part = 0; part < 3; ++part) {
    sl_engine_config config = SL_ENGINE_CONFIG_INIT;
    config.culling.part.index = part, config.culling.part.count = 3;
    sl_engine one = {0};
    ASSERT_OK(sl_engine_create(c.scene, &config, &one));
    ASSERT_OK(sl_engine_frame(one, &view.c, nullptr, nullptr));
    std::vector<sl_item> items(kGrid * kGrid * kGrid);
    std::size_t count = 0;
    ASSERT_OK(sl_engine_visible(one, items.data(), items.size(), &count));
    EXPECT_GT(count, 50u);
    all.insert(all.end(), items.begin(), items.begin() + std::ptrdiff_t(count));
    EXPECT_OK(sl_engine_destroy(one));
  }
  ASSERT_TRUE(twin->frame(view.cpp));
  std::sort(all.begin(), all.end());
  EXPECT_EQ(all, c_ids(visible_in_cpp()));
}

// --- what culling makes of items, and parts of images ----------------------------------------------------------------

TEST_F(CapiEngine, CullStatesAreThoseOfCpp) {
  const BothViews view({7, -12, 7}, {5, 7, 5});
  ASSERT_OK(sl_item_remove(c.scene, 3));
  scene.remove_item(core::ItemId{3});
  ASSERT_OK(sl_engine_commit(engine));
  ASSERT_TRUE(twin->commit());
  const auto expected = twin->cull_states(view.cpp);
  ASSERT_TRUE(expected);
  sl_cull_states states = SL_CULL_STATES_INIT;
  ASSERT_OK(sl_engine_cull_states(engine, &view.c, &states));
  ASSERT_EQ(states.item_count, std::size_t(kGrid * kGrid * kGrid));
  ASSERT_EQ(states.box_count, expected->boxes.size());
  std::vector<std::uint8_t> of_item(states.item_count, 9);
  std::vector<sl_cull_box> boxes(states.box_count);
  states.of_item = of_item.data(), states.item_capacity = of_item.size();
  states.boxes = boxes.data(), states.box_capacity = boxes.size();
  ASSERT_OK(sl_engine_cull_states(engine, &view.c, &states));
  EXPECT_TRUE(std::equal(expected->items.begin(), expected->items.end(), states.items));
  EXPECT_GT(std::min({states.items[SL_CULL_INSIDE], states.items[SL_CULL_INTERSECTING], states.items[SL_CULL_OUTSIDE]}),
            5u);
  const core::Snapshot& snapshot = twin->snapshot();
  for (std::size_t slot = 0; slot < expected->of_slot.size(); ++slot)
    if (const auto s = core::Slot(slot); !snapshot.vacant(s)) {
      EXPECT_EQ(of_item[to_index(snapshot.item(s))], std::uint8_t(expected->of_slot[slot]));
    }
  EXPECT_EQ(of_item[3], SL_CULL_OUTSIDE) << "it is gone";
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    EXPECT_EQ(boxes[i].state, std::int32_t(expected->boxes[i].state));
    EXPECT_EQ(boxes[i].items, expected->boxes[i].items);
    EXPECT_EQ(glm::make_vec3(boxes[i].box.max), snapshot.bounds().origin + core::dvec3(expected->boxes[i].box.max));
  }
  of_item.assign(of_item.size(), 9);
  states.item_capacity = 2;
  ASSERT_OK(sl_engine_cull_states(engine, &view.c, &states));
  EXPECT_EQ(std::count(of_item.begin(), of_item.end(), 9), std::ptrdiff_t(of_item.size() - 2));
  states.of_item = nullptr;
  EXPECT_EQ(sl_engine_cull_states(engine, &view.c, &states), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_engine_cull_states(engine, &view.c, nullptr), SL_ERROR_ARGUMENT);
}

TEST_F(CapiEngine, PartsOfImagesAreCulledApart) {
  const BothViews view({7, -20, 7}, {7, 7, 7}, 2.0);
  std::int32_t width = 0, height = 0;
  std::size_t count = 0;
  ASSERT_OK(sl_image_tiles(400, 200, 130, 3, &width, &height, nullptr, 0, &count));
  const auto expected = engine::image_tiles(400, 200, 130, 3);
  ASSERT_TRUE(expected);
  ASSERT_EQ(count, expected->tiles.size());
  EXPECT_GT(count, 4u);
  std::vector<sl_cropped_tile> tiles(count);
  ASSERT_OK(sl_image_tiles(400, 200, 130, 3, &width, &height, tiles.data(), count, &count));
  EXPECT_EQ(width, expected->width);
  EXPECT_EQ(height, expected->height);
  ASSERT_OK(sl_engine_resize(engine, width, height));
  ASSERT_TRUE(twin->resize(width, height));
  std::vector<bool> taken(400 * 200);
  for (std::size_t i = 0; i < count; ++i) {
    const sl_cropped_tile& tile = tiles[i];
    sl_frame_report report = SL_FRAME_REPORT_INIT;
    ASSERT_OK(sl_engine_frame_tile(engine, &view.c, &tile.tile, &report));
    EXPECT_EQ(report.visible, twin->frame_tile(view.cpp, expected->tiles[i].tile)->visible);
    for (std::int32_t y = tile.y0; y < tile.y1; ++y)
      for (std::int32_t x = tile.x0; x < tile.x1; ++x) {
        EXPECT_FALSE(taken[std::size_t(y * 400 + x)]);
        taken[std::size_t(y * 400 + x)] = true;
      }
  }
  EXPECT_EQ(std::count(taken.begin(), taken.end(), false), 0);
  EXPECT_EQ(sl_engine_frame_tile(engine, &view.c, nullptr, nullptr), SL_ERROR_ARGUMENT);
  const sl_image_tile nothing = {0, 10, 0.0, 0.0};
  EXPECT_EQ(sl_engine_frame_tile(engine, &view.c, &nothing, nullptr), SL_ERROR_FAILED);
  EXPECT_EQ(sl_image_tiles(400, 200, 10, 0, &width, &height, nullptr, 0, &count), SL_ERROR_FAILED);
  EXPECT_EQ(sl_image_tiles(1 << 30, 200, 100, 0, &width, &height, nullptr, 0, &count), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_image_tiles(400, 200, 100, 0, nullptr, &height, nullptr, 0, &count), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_image_tiles(400, 200, 100, 0, &width, &height, nullptr, 1, &count), SL_ERROR_ARGUMENT);
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
