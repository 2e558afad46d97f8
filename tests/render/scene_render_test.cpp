// Whole scenes: culling changes no pixel, a far site looks like a near one, edits show, ids name the items, what a
// scene lacks is not made.
#include <algorithm>
#include <set>

#include <gtest/gtest.h>

#include "sightline/engine/drawing/internal/drawing.h"
#include "sightline/engine/internal/engine_parts.h"
#include "sightline/importers/plant/plant_generator.h"
#include "sightline/tests/support/gl_test.h"

namespace sightline::scene_render_test {
namespace {

/// Draws a set without culling.
bool draw_all(engine::Engine& engine, const core::View& view, const core::VisibleSet& all) {
  engine::Frame frame{view, view, engine.snapshot()};
  frame.all = false;
  return engine::EngineParts::drawing(engine)->draw(frame, all).has_value();
}

using core::Affine;
using core::dvec3;
using core::View;

constexpr int kWidth = 160, kHeight = 120;

class SceneRender : public tests::GlTest {
 protected:
  engine::EngineConfig config(engine::CullerChoice culler = engine::CullerChoice::kAutomatic) {
    engine::EngineConfig c;
    c.draw = c.drawing.ids = true;
    c.width = kWidth;
    c.height = kHeight;
    c.culling.culler = culler;
    c.context.application = &*context;
    return c;
  }

  static engine::Engine make(core::Scene& scene, const engine::EngineConfig& c) {
    auto engine = engine::Engine::create(scene, c);
    EXPECT_TRUE(engine) << engine.error().message;
    return std::move(*engine);
  }

  struct Image {
    image::Image colour;
    image::IdImage ids;
    image::DepthImage depth;
    std::vector<core::ItemId> visible;
  };
  /// What was drawn last.
  static Image image_of(engine::Engine& engine, const View& view) {
    engine.finish();
    const render::RenderTarget& target = engine::EngineParts::drawing(engine)->target();
    return {target.read_colour(), target.read_ids(), target.read_depth(view), {}};
  }
  static Image take(engine::Engine& engine, const View& view) {
    EXPECT_TRUE(engine.frame(view));
    Image image = image_of(engine, view);
    for (const core::Slot slot : engine.visible().sorted_slots())
      if (!engine.snapshot().vacant(slot)) image.visible.push_back(engine.snapshot().item(slot));
    std::sort(image.visible.begin(), image.visible.end());
    return image;
  }

  /// Items that lie at one depth may show either one, since another order of the items draws them in another order; all
  /// other pixels are the same, but for a colour step where chunks have other origins and so other last bits.
  static void expect_same_but_for_ties(const Image& a, const Image& b) {
    ASSERT_EQ(a.ids.ids.size(), b.ids.ids.size());
    int wrong = 0, ties = 0;
    for (std::size_t p = 0; p < a.ids.ids.size(); ++p) {
      int worst = 0;
      for (std::size_t c = 3 * p; c < 3 * p + 3; ++c)
        worst = std::max(worst, std::abs(a.colour.pixels[c] - b.colour.pixels[c]));
      const bool same_depth = a.depth.metres[p] == b.depth.metres[p] ||
                              std::abs(a.depth.metres[p] - b.depth.metres[p]) <= 2e-5f * a.depth.metres[p];
      const bool tie = a.ids.ids[p] != b.ids.ids[p] && same_depth;
      ties += tie;
      if (tie || (a.ids.ids[p] == b.ids.ids[p] && worst <= 1 && same_depth)) continue;
      if (++wrong <= 4) {
        ADD_FAILURE() << "pixel " << p % kWidth << ", " << p / kWidth << ": items " << int(a.ids.ids[p]) - 1 << " and "
                      << int(b.ids.ids[p]) - 1 << ", depths " << a.depth.metres[p] << " and " << b.depth.metres[p]
                      << ", colours " << worst << " apart";
      }
    }
    EXPECT_EQ(wrong, 0);
    EXPECT_LE(ties, 4);
  }

  static View look(const dvec3& eye, const dvec3& target) {
    return *View::perspective({eye, target, {0, 0, 1}}, 1.0, double(kWidth) / kHeight, 0.1);
  }

  /// Views of a plant of a few thousand items (see generate_plant for where it stands), all around and inside.
  static std::vector<View> plant_views(const dvec3& offset = dvec3(0.0)) {
    std::vector<View> views;
    for (const auto& [eye, target] : {std::pair{dvec3(-60, -60, 50), dvec3(0, 0, 5)},
                                      {dvec3(5, -20, 4), dvec3(-10, 10, 3)},
                                      {dvec3(-20, 1, 2), dvec3(20, 2, 3)},
                                      {dvec3(0, 0, 30), dvec3(0.1, 0, 0)}})
      views.push_back(look(eye + offset, target + offset));
    return views;
  }

  static core::MeshId add_triangle(core::Scene& scene) {
    core::Mesh triangle;
    triangle.positions = {{-0.5f, 0, -0.5f}, {0.5f, 0, -0.5f}, {0, 0, 0.5f}};
    triangle.indices = {0, 1, 2};
    return scene.add_mesh(triangle).value();
  }

  void expect_shown_as_if_built_anew(engine::Engine& edited, core::Scene& scene) {
    engine::Engine fresh = make(scene, config());
    for (const View& view : plant_views()) {
      const Image a = take(edited, view), b = take(fresh, view);
      EXPECT_EQ(a.visible, b.visible);
      expect_same_but_for_ties(a, b);
    }
  }
};

TEST_F(SceneRender, CullingChangesNoPixel) {
  core::Scene scene;
  ASSERT_TRUE(importers::generate_plant({3000, 3}, scene));
  engine::Engine linear = make(scene, config(engine::CullerChoice::kLinear));
  engine::Engine tree = make(scene, config(engine::CullerChoice::kCpu));
  for (View& view : plant_views()) {
    const Image a = take(linear, view), b = take(tree, view);
    EXPECT_EQ(a.visible, b.visible);
    EXPECT_LT(a.visible.size(), 3000u + 1);
    expect_same_but_for_ties(a, b);
    // Nothing that shows may be culled.
    for (const std::uint32_t id : a.ids.ids) {
      if (id == 0) continue;
      ASSERT_TRUE(std::binary_search(b.visible.begin(), b.visible.end(), core::ItemId{id - 1}));
    }
  }
}

/// Its counts arrive late, in order, and with the frame they are of; edits and new scene versions reach it.
TEST_F(SceneRender, TheGpuCullerChangesNoPixel) {
  core::Scene scene;
  ASSERT_TRUE(importers::generate_plant({3000, 3}, scene));
  engine::EngineConfig no_rebuild = config(engine::CullerChoice::kGpu);
  no_rebuild.culling.rebuild_share = 0.0;
  engine::Engine gpu = make(scene, no_rebuild);
  EXPECT_EQ(name_of(gpu.plan().culler), "gpu");
  std::uint64_t frame = 0;
  const auto check = [&] {
    engine::Engine cpu = make(scene, config(engine::CullerChoice::kCpu));
    for (const View& view : plant_views()) {
      const Image a = take(cpu, view), b = take(gpu, view);
      expect_same_but_for_ties(a, b);
      const auto late = gpu.take_late_report();
      ASSERT_TRUE(late);
      EXPECT_EQ(late->frame, frame++);
      EXPECT_GE(late->visible, std::int64_t(a.visible.size()));
      EXPECT_LE(late->visible, std::int64_t(a.visible.size()) + 1);
      EXPECT_FALSE(gpu.take_late_report());
    }
  };
  check();
  for (core::ItemId item{0}; to_index(item) < 3000; item = core::ItemId{to_index(item) + 7})
    scene.set_visible(item, false);
  for (core::ItemId item{1}; to_index(item) < 3000; item = core::ItemId{to_index(item) + 40})
    scene.set_placement(item, core::translation({to_index(item) / 80.0 - 18.0, 3, 9}));
  ASSERT_TRUE(gpu.commit());
  check();
  ASSERT_TRUE(gpu.rebuild());
  check();
}

/// Culling alone draws nothing, and makes nothing to draw with.
TEST_F(SceneRender, TheGpuCullerWorksWithoutDrawing) {
  core::Scene scene;
  ASSERT_TRUE(importers::generate_plant({3000, 3}, scene));
  engine::EngineConfig no_draw = config(engine::CullerChoice::kGpu);
  no_draw.draw = no_draw.drawing.ids = false;
  engine::Engine gpu = make(scene, no_draw);
  engine::Engine cpu = make(scene, config(engine::CullerChoice::kCpu));
  for (const View& view : plant_views()) {
    const auto report = gpu.frame(view);
    ASSERT_TRUE(report);
    EXPECT_EQ(report->visible, -1);
    gpu.finish();
    const auto late = gpu.take_late_report();
    ASSERT_TRUE(late);
    EXPECT_EQ(late->visible, cpu.frame(view)->visible);
  }
  EXPECT_EQ(engine::EngineParts::drawing(gpu)->target().width(), 0);
}

TEST_F(SceneRender, UnculledDrawingShowsTheSame) {
  core::Scene scene;
  ASSERT_TRUE(importers::generate_plant({2000, 4}, scene));
  engine::Engine engine = make(scene, config());
  for (const View& view : plant_views()) {
    const Image culled = take(engine, view);
    core::VisibleSet all;
    all.ranges.push_back({0, std::uint32_t(engine.snapshot().size())});
    ASSERT_TRUE(draw_all(engine, view, all));
    expect_same_but_for_ties(culled, image_of(engine, view));
  }
}

TEST_F(SceneRender, AFarSiteLooksTheSame) {
  const dvec3 far(3e6, 7e6, 1e3);
  core::Scene near_scene, far_scene;
  ASSERT_TRUE(importers::generate_plant({3000, 5}, near_scene));
  ASSERT_TRUE(importers::generate_plant({3000, 5}, far_scene));
  far_scene.set_transform(far_scene.root(), core::translation(far));
  engine::Engine a = make(near_scene, config()), b = make(far_scene, config());
  const auto near_views = plant_views(), far_views = plant_views(far);
  for (std::size_t i = 0; i < near_views.size(); ++i) {
    SCOPED_TRACE(i);
    const Image here = take(a, near_views[i]), there = take(b, far_views[i]);
    EXPECT_EQ(here.visible, there.visible);
    expect_same_but_for_ties(here, there);
  }
}

TEST_F(SceneRender, EveryKindShowsUnderItsId) {
  core::Scene scene;
  const core::Primitive kinds[] = {core::Pyramid{1, 1, 0.5f, 0.5f, 0, 0, 1},
                                   core::Box{1, 1, 1},
                                   core::RectangularTorus{0.3f, 0.6f, 0.4f, 3},
                                   core::CircularTorus{0.4f, 0.2f, 3},
                                   core::EllipticalDish{0.6f, 0.4f},
                                   core::SphericalDish{0.6f, 0.3f},
                                   core::Snout{0.6f, 0.3f, 1, 0, 0, 0, 0, 0, 0},
                                   core::Cylinder{0.5f, 1},
                                   core::Sphere{1},
                                   core::Line{-0.5f, 0.5f}};
  for (int i = 0; i < core::kPrimitiveKindCount; ++i)
    scene.add_primitive(scene.root(), kinds[i], core::translation({1.5 * (i % 4), 0, 1.5 * (i / 4)}));
  scene.add_mesh_instance(scene.root(), add_triangle(scene), core::translation({3, 0, 3}));
  engine::Engine engine = make(scene, config());
  const Image image = take(engine, look({2.2, -8, 1.6}, {2.2, 0, 1.6}));
  const std::set<std::uint32_t> seen(image.ids.ids.begin(), image.ids.ids.end());
  for (std::uint32_t id = 0; id <= 11; ++id) EXPECT_TRUE(seen.count(id)) << "id " << id;
  EXPECT_EQ(seen.size(), 12u);
}

/// Items of one kind are drawn in the order of their slots.
TEST_F(SceneRender, WhatIsDrawnFirstStaysWhereDepthsAreEqual) {
  core::Scene scene;
  const core::MeshId triangle = add_triangle(scene);
  for (int i = 0; i < 3; ++i) {
    scene.add_primitive(scene.root(), core::Cylinder{0.5f, 1}, core::translation({-1, 0, 0}));
    scene.add_mesh_instance(scene.root(), triangle, core::translation({1, 0, 0}));
  }
  engine::Engine engine = make(scene, config());
  const Image image = take(engine, look({0, -4, 0}, {0, 0, 0}));
  std::set<std::uint32_t> first{0};
  for (const core::Kind kind : {core::Kind::kCylinder, core::Kind::kMesh})
    first.insert(to_index(engine.snapshot().item(engine.snapshot().of_kind(kind).members[0])) + 1);
  EXPECT_EQ(std::set<std::uint32_t>(image.ids.ids.begin(), image.ids.ids.end()), first);
}

TEST_F(SceneRender, OnlyWhatTheSceneHoldsIsMade) {
  core::Scene scene;
  scene.add_primitive(scene.root(), core::Cylinder{1, 2});
  engine::Engine engine = make(scene, config());
  std::set<std::string> used;
  for (const engine::PlanEntry& e : engine.plan().entries)
    if (e.used) used.insert(e.feature);
  EXPECT_EQ(used, (std::set<std::string>{"linear culler", "cylinder program (ray-cast)", "item-id target"}));

  auto gpu = gpuscene::GpuScene::create(*context, engine.snapshot());
  ASSERT_TRUE(gpu);
  EXPECT_EQ(gpu->batches().size(), 1u);
  EXPECT_EQ(gpu->meshes().vertices().size(), 0u);
}

TEST_F(SceneRender, AnEmptySceneIsBackground) {
  core::Scene scene;
  engine::Engine engine = make(scene, config());
  const Image image = take(engine, look({0, -5, 0}, {0, 0, 0}));
  EXPECT_TRUE(std::all_of(image.ids.ids.begin(), image.ids.ids.end(), [](std::uint32_t id) { return id == 0; }));
}

TEST_F(SceneRender, EditsShowAsIfBuiltAnew) {
  core::Scene scene;
  ASSERT_TRUE(importers::generate_plant({1500, 6}, scene));
  engine::Engine edited = make(scene, config());
  for (core::ItemId item{0}; to_index(item) < 1500; item = core::ItemId{to_index(item) + 7})
    scene.set_visible(item, false);
  for (core::ItemId item{1}; to_index(item) < 1500; item = core::ItemId{to_index(item) + 11}) {
    Affine placement = scene.placement(item);
    placement.origin.z += 3.0;
    scene.set_placement(item, placement);
  }
  for (core::ItemId item{2}; to_index(item) < 1500; item = core::ItemId{to_index(item) + 13}) scene.remove_item(item);
  ASSERT_TRUE(edited.commit());
  scene.add_primitive(scene.root(), core::Cylinder{2, 4}, core::translation({0, 0, 12}));
  scene.add_primitive(scene.root(), core::Sphere{3}, core::translation({5, 0, 12}));
  ASSERT_TRUE(edited.commit());
  expect_shown_as_if_built_anew(edited, scene);
}

/// Records of appended slots, as long as there is memory, and everything anew after that: the image is the same.
TEST_F(SceneRender, AppendedSlotsShowAsIfBuiltAnew) {
  core::Scene scene;
  ASSERT_TRUE(importers::generate_plant({1500, 9}, scene));
  const core::MeshId mesh = add_triangle(scene);
  scene.add_mesh_instance(scene.root(), mesh);
  engine::EngineConfig no_rebuild = config();
  no_rebuild.culling.rebuild_share = 0.0;
  engine::Engine edited = make(scene, no_rebuild);
  for (int round = 0; round < 12; ++round) {
    SCOPED_TRACE(round);
    for (core::ItemId item = core::ItemId(round); to_index(item) < 1500; item = core::ItemId{to_index(item) + 40}) {
      Affine placement = scene.placement(item);
      placement.origin = {to_index(item) % 30 - 15.0, round - 6.0, to_index(item) % 11};
      scene.set_placement(item, placement);
    }
    for (int i = 0; i < 10; ++i) scene.add_mesh_instance(scene.root(), mesh, core::translation({i - 5, round - 6, 14}));
    ASSERT_TRUE(edited.commit());
    if (round % 4 != 3) continue;
    ASSERT_NO_FATAL_FAILURE(expect_shown_as_if_built_anew(edited, scene));
  }
}

std::vector<std::uint32_t> words_of(const gpuscene::GpuScene& scene, gpuscene::BatchKind kind) {
  const gpuscene::Batch& batch = *scene.batch(kind);
  std::vector<std::uint32_t> words(batch.count * gpuscene::record_bytes(kind) / sizeof(std::uint32_t));
  batch.records.read(0, words.size() * sizeof(std::uint32_t), words.data());
  return words;
}

/// Records are appended until the memory is exactly full; one more takes more memory.
TEST_F(SceneRender, RecordsFillTheirMemoryToTheLast) {
  core::Scene scene;
  const core::MeshId mesh = add_triangle(scene);
  for (int i = 0; i < 20; ++i) {
    scene.add_primitive(scene.root(), core::Sphere{1}, core::translation({2.0 * i, 0, 0}));
    scene.add_mesh_instance(scene.root(), mesh, core::translation({2.0 * i, 0, 2}));
  }
  ASSERT_TRUE(scene.commit());
  core::Snapshot snapshot(scene);
  auto gpu = gpuscene::GpuScene::create(*context, snapshot);
  ASSERT_TRUE(gpu);
  for (const bool meshes : {false, true}) {
    const auto batch = [&]() -> const gpuscene::Batch& {
      return *gpu->batch(meshes ? gpuscene::BatchKind::kMesh : gpuscene::BatchKind::kSphereCap);
    };
    const auto append = [&](std::uint32_t count) {
      for (std::uint32_t i = 0; i < count; ++i)
        if (meshes)
          scene.add_mesh_instance(scene.root(), mesh);
        else
          scene.add_primitive(scene.root(), core::Sphere{1});
      snapshot.apply(*scene.commit());
      return gpu->append(snapshot).value();
    };
    const std::uint32_t room = batch().capacity - batch().count;
    ASSERT_GT(room, 2u);
    const std::uint32_t full = batch().capacity;
    EXPECT_FALSE(append(1));
    EXPECT_FALSE(append(room - 1)) << "exactly full";
    EXPECT_EQ(batch().count, full);
    EXPECT_EQ(batch().capacity, full);
    EXPECT_TRUE(append(1));
    EXPECT_EQ(batch().count, full + 1);
    EXPECT_GT(batch().capacity, full + 1);
    EXPECT_FALSE(append(1));
    const auto anew = gpuscene::GpuScene::create(*context, snapshot);
    ASSERT_TRUE(anew);
    EXPECT_EQ(words_of(*gpu, batch().kind), words_of(*anew, batch().kind));
    if (meshes) {
      EXPECT_EQ(gpu->meshes().records(), batch().count);
    }
  }
}

/// Ranges may hold vacant slots, and long ones are drawn without a look at their items.
TEST_F(SceneRender, VacantSlotsOfRangesAreNotDrawn) {
  core::Scene scene;
  ASSERT_TRUE(importers::generate_plant({3000, 8}, scene));
  const core::MeshId mesh = add_triangle(scene);
  for (int i = 0; i < 300; ++i) {
    const Affine place = core::translation({i % 20 - 10, i / 20 - 8, 12});
    scene.add_mesh_instance(scene.root(), mesh, place);
    scene.add_primitive(scene.root(), core::Box{0.5f, 0.5f, 0.5f}, place);
    scene.add_primitive(scene.root(), core::Line{-0.5f, 0.5f}, place);
    scene.add_primitive(scene.root(), core::Pyramid{1, 1, 0.5f, 0.5f, 0, 0, 1}, place);
  }
  engine::EngineConfig c = config();
  c.context.gl_state = engine::GlState::kLeave;  // draws below bypass the engine, which then has none to give back
  engine::Engine engine = make(scene, c);
  const auto ids_of_everything = [&](const View& view) {
    core::VisibleSet all;
    all.ranges.push_back({0, std::uint32_t(engine.snapshot().size())});
    EXPECT_TRUE(draw_all(engine, view, all));
    engine.finish();
    const image::IdImage image = engine::EngineParts::drawing(engine)->target().read_ids();
    return std::set<std::uint32_t>(image.ids.begin(), image.ids.end());
  };
  for (core::ItemId item{0}; to_index(item) < scene.item_slots(); item = core::ItemId{to_index(item) + 2})
    scene.set_visible(item, false);
  for (core::ItemId item{1}; to_index(item) < scene.item_slots(); item = core::ItemId{to_index(item) + 6})
    scene.remove_item(item);
  ASSERT_TRUE(engine.commit());
  for (const View& view : plant_views())
    for (const std::uint32_t id : ids_of_everything(view)) {
      if (id != 0) {
        ASSERT_TRUE(scene.contains_item(core::ItemId{id - 1}) && scene.item_visible(core::ItemId{id - 1}))
            << "item " << id - 1;
      }
    }
  ASSERT_TRUE(engine.rebuild());
  for (core::ItemId item{0}; to_index(item) < scene.item_slots(); ++item)
    if (scene.contains_item(item)) scene.set_visible(item, to_index(item) % 2 == 0);
  ASSERT_TRUE(engine.commit());
  std::size_t seen = 0;
  for (const View& view : plant_views())
    for (const std::uint32_t id : ids_of_everything(view)) {
      if (id != 0) {
        ASSERT_EQ((id - 1) % 2, 0u) << "shown where records were made for a hidden one";
      }
      ++seen;
    }
  EXPECT_GT(seen, 500u);
}

TEST_F(SceneRender, TransparencyIsDitheredAndIdsStayExact) {
  core::Scene scene;
  core::Material glass;
  glass.alpha = 0.5f;
  scene.set_material(scene.root(), scene.add_material(glass));
  scene.add_primitive(scene.root(), core::Box{4, 0.1f, 4});
  engine::Engine engine = make(scene, config());
  const Image image = take(engine, look({0, -3, 0}, {0, 0, 0}));
  const auto hits = std::count(image.ids.ids.begin(), image.ids.ids.end(), 1u);
  // Two layers of the box (front and back side, same pattern) at half coverage.
  EXPECT_NEAR(double(hits) / (kWidth * kHeight), 0.5, 0.05);
}

}  // namespace
}  // namespace sightline::scene_render_test
