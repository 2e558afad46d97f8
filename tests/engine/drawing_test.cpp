// What may change while an engine runs and draws: the culler, the size, the view that culls. Images are compared with
// those of engines made for the purpose.
#include <filesystem>
#include <random>

#include <gtest/gtest.h>
#include <unistd.h>

#include "sightline/engine/internal/engine_parts.h"
#include "sightline/gl/internal/program_cache.h"
#include "sightline/gpuprims/internal/primitives.h"
#include "sightline/tests/engine/drawn_grid.h"

namespace sightline::tests::drawing_test {
namespace {

using engine::CullerChoice;
using engine::Engine;

using DrawingTest = DrawnGrid;

/// The twin is the same engine when it tests every box.
TEST_F(DrawingTest, CullersMayBeChangedInAnyOrder) {
  core::Scene scene;
  fill(scene, 22);
  auto engine = Engine::create(scene, config(CullerChoice::kAutomatic));
  ASSERT_TRUE(engine);
  const engine::Drawing* drawing = engine::EngineParts::drawing(*engine);
  EXPECT_EQ(drawing->gpu_culler(), nullptr);
  const std::pair<CullerChoice, const char*> choices[] = {{CullerChoice::kAutomatic, "cpu"},
                                                          {CullerChoice::kLinear, "linear"},
                                                          {CullerChoice::kCpu, "cpu"},
                                                          {CullerChoice::kGpu, "gpu"},
                                                          {CullerChoice::kHybrid, "hybrid"}};
  constexpr unsigned kSeed = 5;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937 random{kSeed};
  for (int round = 0; round < 24; ++round) {
    const auto& [choice, name] = choices[random() % std::size(choices)];
    SCOPED_TRACE(testing::Message() << "round " << round << " to " << name);
    if (round % 10 == 9) {  // among edits, appended items included
      for (int i = 0; i < 200; ++i) scene.set_visible(core::ItemId(random() % scene.item_slots()), random() % 2 == 0);
      for (int i = 0; i < 40; ++i)
        scene.add_primitive(scene.root(), core::Box{0.3f, 0.3f, 0.3f},
                            core::translation({0.5 * i, 11.5, 0.5 + 0.5 * round}));
      ASSERT_TRUE(engine->commit());
    }
    ASSERT_TRUE(engine->set_culler(choices[random() % std::size(choices)].first));  // and straight on
    ASSERT_TRUE(engine->set_culler(choice));
    EXPECT_EQ(name_of(engine->plan().culler), name);
    EXPECT_EQ(engine->controller() != nullptr, choice == CullerChoice::kHybrid);
    const core::View eye = view(0.2 * round);
    for (int frame = 0; frame < 3; ++frame) {
      const auto report = engine->frame(eye);
      ASSERT_TRUE(report);
      if (!engine->controller()) {
        EXPECT_EQ(name_of(report->culler), name);
      }
    }
    const image::Image image = engine::EngineParts::drawing(*engine)->target().read_colour();
    ASSERT_TRUE(engine->set_culler(CullerChoice::kLinear) && engine->frame(eye));
    const auto difference = image::compare(image, engine::EngineParts::drawing(*engine)->target().read_colour());
    ASSERT_TRUE(difference);
    EXPECT_EQ(difference->max, 0);
    EXPECT_EQ(engine::EngineParts::drawing(*engine), drawing) << "made anew";
  }
  EXPECT_NE(drawing->gpu_culler(), nullptr);
}

TEST_F(DrawingTest, AGpuCullerComesToAnEngineThatDoesNotDraw) {
  core::Scene scene;
  fill(scene, 8);
  engine::EngineConfig c = config(CullerChoice::kCpu);
  c.draw = false;
  auto engine = Engine::create(scene, c);
  ASSERT_TRUE(engine);
  EXPECT_EQ(engine::EngineParts::drawing(*engine), nullptr);
  const auto expected = engine->frame(view(0.3));
  ASSERT_TRUE(expected);
  ASSERT_TRUE(engine->set_culler(CullerChoice::kGpu));
  const auto report = engine->frame(view(0.3));
  ASSERT_TRUE(report);
  EXPECT_EQ(name_of(report->culler), "gpu");
  engine->finish();
  const auto late = engine->take_late_report();
  ASSERT_TRUE(late);
  EXPECT_EQ(late->frame, 1u);
  EXPECT_EQ(late->visible, expected->visible);
}

TEST_F(DrawingTest, AnotherSizeIsThatOfANewEngine) {
  core::Scene scene;
  fill(scene, 12);
  auto engine = Engine::create(scene, config(CullerChoice::kCpu));
  ASSERT_TRUE(engine);
  for (const auto& [width, height] : {std::pair{192, 128}, {64, 64}, {301, 17}, {1, 1}, {640, 360}}) {
    SCOPED_TRACE(testing::Message() << width << " x " << height);
    ASSERT_TRUE(engine->frame(view(0.1)));  // may still be on its way when its target goes
    ASSERT_TRUE(engine->resize(width, height));
    auto fresh = Engine::create(scene, config(CullerChoice::kCpu, width, height));
    ASSERT_TRUE(fresh);
    const core::View eye = view(0.4, double(width) / height);
    ASSERT_TRUE(engine->frame(eye) && fresh->frame(eye));
    expect_same_image(*engine, *fresh);
  }
  for (const auto& [width, height] : {std::pair{0, 10}, {10, -1}, {1 << 20, 10}}) {
    SCOPED_TRACE(testing::Message() << width << " x " << height);
    EXPECT_FALSE(engine->resize(width, height));
    EXPECT_EQ(engine::EngineParts::drawing(*engine)->target().width(), 640);
    ASSERT_TRUE(engine->frame(view(0.4)));
  }
}

/// Two windows on one scene; the twin is a third engine, made anew.
TEST_F(DrawingTest, TwoEnginesDrawOneScene) {
  core::Scene scene;
  fill(scene, 22);
  auto a = Engine::create(scene, config(CullerChoice::kCpu)), b = Engine::create(scene, config(CullerChoice::kGpu));
  ASSERT_TRUE(a && b);
  constexpr unsigned kSeed = 6;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937 random{kSeed};
  for (int round = 0; round < 6; ++round) {
    SCOPED_TRACE(round);
    for (int part = 0; part < 3; ++part) {
      for (int i = 0; i < 60; ++i) scene.set_visible(core::ItemId(random() % scene.item_slots()), random() % 3 == 0);
      scene.add_primitive(scene.root(), core::Box{2, 2, 2}, core::translation({11.0, 11.0, 4.0 * part + round}));
      ASSERT_TRUE(part == 0 ? a->commit() : part == 1 ? b->commit() : scene.commit().map([](const auto&) {}));
    }
    ASSERT_TRUE(a->commit() && b->commit());
    auto fresh = Engine::create(scene, config(CullerChoice::kLinear));
    ASSERT_TRUE(fresh);
    const core::View eye = view(0.4 * round);
    ASSERT_TRUE(a->frame(eye) && b->frame(eye) && fresh->frame(eye));
    expect_same_image(*a, *fresh, 1);
    expect_same_image(*b, *fresh, 1);
  }
}

/// Each draws into its own context, whichever was current.
TEST_F(DrawingTest, EnginesWithContextsOfTheirOwn) {
  core::Scene dense, sparse;
  fill(dense, 22);
  fill(sparse, 22);
  for (core::ItemId item{0}; to_index(item) < sparse.item_slots(); item = core::ItemId{to_index(item) + 3})
    sparse.set_visible(item, false);
  for (const CullerChoice culler : {CullerChoice::kCpu, CullerChoice::kGpu}) {
    engine::EngineConfig own = config(culler);
    own.context.application = nullptr;
    auto a = Engine::create(dense, own), b = Engine::create(sparse, own);
    ASSERT_TRUE(a && b);
    ASSERT_TRUE(context->make_current());
    auto expected_a = Engine::create(dense, config(culler)), expected_b = Engine::create(sparse, config(culler));
    ASSERT_TRUE(expected_a && expected_b);
    for (int round = 0; round < 3; ++round) {
      SCOPED_TRACE(testing::Message() << "round " << round);
      const core::View eye = view(0.3 * round);
      ASSERT_TRUE(a->frame(eye) && b->frame(eye) && expected_a->frame(eye) && expected_b->frame(eye));
      expect_same_image(*a, *expected_a);
      expect_same_image(*b, *expected_b);
      dense.set_visible(core::ItemId(5000 + round), false);
      sparse.set_visible(core::ItemId(5000 + round), true);
      ASSERT_TRUE(a->commit() && b->commit() && expected_a->commit() && expected_b->commit());
      if (round == 1) {
        ASSERT_TRUE(a->set_culler(CullerChoice::kHybrid) && b->set_culler(CullerChoice::kGpu));
      }
    }
    ASSERT_TRUE(context->make_current());
    { Engine gone = std::move(*a); }  // frees nothing of what is current
    ASSERT_TRUE(expected_a->frame(view(0)) && b->frame(view(0)) && expected_b->frame(view(0)));
    expect_same_image(*b, *expected_b);
    for (const std::string& error : engine::EngineParts::drawing(*expected_b)->take_gl_errors()) ADD_FAILURE() << error;
  }
}

/// Added, edited and removed, more of them than there was room for; the twin is an engine made anew.
TEST_F(DrawingTest, MaterialsFollowTheScene) {
  constexpr unsigned kSeed = 7;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  for (const CullerChoice culler : {CullerChoice::kCpu, CullerChoice::kGpu, CullerChoice::kHybrid}) {
    core::Scene scene;
    fill(scene, 22);
    engine::EngineConfig c = config(culler);
    switch_often(c);
    auto engine = Engine::create(scene, c);
    ASSERT_TRUE(engine);
    SCOPED_TRACE(name_of(engine->plan().culler));
    std::mt19937 random{kSeed};
    const auto channel = [&] { return float(random() % 256) / 255.0f; };
    std::vector<core::MaterialId> materials;
    for (int round = 0; round < 8; ++round) {
      SCOPED_TRACE(round);
      const auto some_look = [&] {
        core::Material look{.name = "look", .colour = {channel(), channel(), channel()}};
        if (random() % 4 == 0) look.alpha = 0.5f;
        return look;
      };
      for (int i = 0; i < (round == 4 ? 200 : 5); ++i) materials.push_back(scene.add_material(some_look()));
      for (int i = 0; i < 400 && round % 2 == 0; ++i)
        scene.set_material(core::ItemId(random() % scene.item_slots()), materials[random() % materials.size()]);
      for (int i = 0; i < 3; ++i) scene.update_material(materials[random() % materials.size()], some_look());
      scene.remove_material(materials[0]);
      materials.erase(materials.begin());
      ASSERT_TRUE(engine->commit());
      auto fresh = Engine::create(scene, config(CullerChoice::kCpu));
      ASSERT_TRUE(fresh);
      const core::View eye = view(0.4 * round);
      for (int frame = 0; frame < 3; ++frame) ASSERT_TRUE(engine->frame(eye));
      ASSERT_TRUE(fresh->frame(eye));
      ASSERT_NO_FATAL_FAILURE(expect_same_image(*engine, *fresh, 1));
    }
  }
}

/// A pipe looks into its neighbour that has turned to glass.
TEST_F(DrawingTest, EndsShowWhereAMaterialTurnsClear) {
  core::Scene scene;
  const core::MaterialId pane = scene.add_material({});
  for (int i = 0; i < 5; ++i)
    scene.add_primitive(scene.root(), core::Cylinder{1.0f, 2.0f}, core::translation({0, 0, 2.0 * i}),
                        i % 2 == 1 ? pane : core::MaterialId{});
  auto engine = Engine::create(scene, config(CullerChoice::kCpu));
  ASSERT_TRUE(engine);
  EXPECT_EQ(engine::EngineParts::joints(*engine).count(), 8u);
  scene.update_material(pane, {.name = "glass", .alpha = 0.0f});
  ASSERT_TRUE(engine->commit());
  auto fresh = Engine::create(scene, config(CullerChoice::kCpu));
  ASSERT_TRUE(fresh);
  const core::View eye = *core::View::perspective({{6, 1, 12}, {0, 0, 4}, {0, 0, 1}}, 0.9, 1.5, 0.1);
  ASSERT_TRUE(engine->frame(eye) && fresh->frame(eye));
  expect_same_image(*engine, *fresh);
}

TEST_F(DrawingTest, DrawsFromAsideWhatAnotherViewSees) {
  core::Scene scene;
  fill(scene, 12);
  const core::View narrow = *core::View::perspective({{-9, 5, 5}, {5, 5, 5}, {0, 0, 1}}, 0.1, 1.5, 0.1);
  const core::View aside = *core::View::perspective({{5, -40, 30}, {5, 5, 5}, {0, 0, 1}}, 0.7, 1.5, 0.1);
  auto cpu = Engine::create(scene, config(CullerChoice::kCpu));
  ASSERT_TRUE(cpu && cpu->frame(narrow));
  std::vector<bool> seen(scene.item_slots());
  for (const core::Slot slot : cpu->visible().sorted_slots()) seen[to_index(cpu->snapshot().item(slot))] = true;
  auto gpu = Engine::create(scene, config(CullerChoice::kGpu));
  ASSERT_TRUE(gpu && gpu->frame({.view = aside, .cull_view = &narrow}));
  const auto report = cpu->frame({.view = aside, .cull_view = &narrow});
  ASSERT_TRUE(report);
  EXPECT_EQ(report->visible, std::count(seen.begin(), seen.end(), true));
  EXPECT_LT(report->visible, 1000);

  for (core::ItemId item{0}; to_index(item) < scene.item_slots(); ++item) scene.set_visible(item, seen[to_index(item)]);
  auto expected = Engine::create(scene, config(CullerChoice::kCpu));
  ASSERT_TRUE(expected && expected->frame(aside));
  expect_same_image(*cpu, *expected, 1);
  expect_same_image(*gpu, *expected, 1);
}

TEST_F(DrawingTest, ProgramsAreKeptWhereTheConfigurationSays) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::path(testing::TempDir()) / ("sightline-drawing-" + std::to_string(getpid()));
  const auto files = [&] {
    std::error_code none;
    return std::distance(fs::directory_iterator(folder, none), fs::directory_iterator());
  };
  fs::remove_all(folder);
  core::Scene scene;
  fill(scene, 2);
  engine::EngineConfig c = config(CullerChoice::kAutomatic);
  c.context.program_cache = fs::path();
  ASSERT_TRUE(Engine::create(scene, c));
  EXPECT_EQ(gl().program_cache, nullptr);
  c.context.program_cache = folder;
  for (int round = 0; round < 2; ++round) {
    auto engine = Engine::create(scene, c);
    ASSERT_TRUE(engine && engine->frame(view(0.1)));
    ASSERT_NE(gl().program_cache, nullptr);
    EXPECT_EQ(files(), gl().program_cache->enabled() ? 3 : 0) << "proxies, cylinders and boxes";
  }
  fs::remove_all(folder);
}

TEST_F(DrawingTest, ThePlanNamesTheProgramsThatAreMade) {
  const core::Primitive primitives[] = {core::Pyramid{1, 1, 0.5f, 0.5f, 0, 0, 1},
                                        core::Box{1, 1, 1},
                                        core::RectangularTorus{1, 2, 1, 1},
                                        core::CircularTorus{2, 1, 1},
                                        core::EllipticalDish{1, 1},
                                        core::SphericalDish{1, 0.5f},
                                        core::Snout{1, 0.5f, 1, 0, 0, 0, 0, 0, 0},
                                        core::Cylinder{1, 1},
                                        core::Sphere{1},
                                        core::Line{0, 1}};
  for (int i = 0; i <= int(std::size(primitives)); ++i) {
    core::Scene scene;
    if (i < int(std::size(primitives)))
      scene.add_primitive(scene.root(), primitives[i]);
    else
      scene.add_mesh_instance(scene.root(), scene.add_mesh(gpuprims::tessellate(core::Box{1, 1, 1})).value());
    auto engine = Engine::create(scene, config(CullerChoice::kAutomatic));
    ASSERT_TRUE(engine);
    const core::Kind kind = scene.kind(core::ItemId{0});
    SCOPED_TRACE(core::name_of(kind));
    std::string program(gpuscene::name_of(gpuscene::batch_of(kind)));
    std::replace(program.begin(), program.end(), '_', ' ');
    int programs = 0;
    for (const engine::PlanEntry& entry : engine->plan().entries) {
      if (entry.feature.find(" program") == std::string::npos) continue;
      ++programs;
      EXPECT_EQ(entry.used, entry.feature.rfind(program + " program", 0) == 0) << entry.feature;
    }
    EXPECT_EQ(programs, gpuscene::kBatchKindCount);
  }
}

/// What an application reads of the last frame, and what it is told where there is none.
TEST_F(DrawingTest, ImagesAreReadThroughTheEngine) {
  engine::EngineConfig config;
  config.draw = config.drawing.ids = true;
  config.width = 60, config.height = 40;
  core::Scene scene;
  scene.add_primitive(scene.root(), core::Box{1, 1, 1});
  auto engine = Engine::create(scene, config);
  ASSERT_TRUE(engine);
  const core::View view = *core::View::perspective({{0, -4, 0}, {0, 0, 0}, {0, 0, 1}}, 0.7, 1.5, 0.1);
  ASSERT_TRUE(engine->frame(view));
  const render::RenderTarget& target = engine::EngineParts::drawing(*engine)->target();
  EXPECT_EQ(engine->read_colour()->pixels, target.read_colour().pixels);
  EXPECT_EQ(engine->read_depth(view)->metres, target.read_depth(view).metres);
  const image::IdImage ids = *engine->read_ids();
  EXPECT_EQ(ids.ids, target.read_ids().ids);
  EXPECT_EQ(ids.ids[20 * 60 + 30], 1u) << "the box";
  EXPECT_EQ(ids.ids[0], 0u);
  EXPECT_TRUE(*engine->covered());
  EXPECT_NE(*engine->framebuffer(), 0u);
  EXPECT_EQ(engine->renderer(), engine::EngineParts::drawing(*engine)->context().renderer());
  EXPECT_TRUE(engine->take_gl_errors().empty());
  const core::View away = *core::View::perspective({{0, -4, 0}, {0, -8, 0}, {0, 0, 1}}, 0.7, 1.5, 0.1);
  ASSERT_TRUE(engine->frame(away));
  EXPECT_FALSE(*engine->covered());

  config.drawing.ids = false;
  auto without_ids = Engine::create(scene, config);
  ASSERT_TRUE(without_ids->frame(view));
  EXPECT_EQ(without_ids->read_ids().error().message, "image: ids are not drawn without EngineConfig::drawing.ids");
  auto culling_alone = Engine::create(scene, {});
  ASSERT_TRUE(culling_alone->frame(view));
  EXPECT_TRUE(culling_alone->renderer().empty());
  EXPECT_FALSE(culling_alone->read_colour());
  EXPECT_FALSE(culling_alone->read_depth(view));
  EXPECT_FALSE(culling_alone->covered());
  EXPECT_FALSE(culling_alone->framebuffer());
}

}  // namespace
}  // namespace sightline::tests::drawing_test
