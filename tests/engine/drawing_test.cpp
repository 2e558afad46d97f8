// What may change while an engine runs and draws: the culler, the size, the view that culls. Pictures are compared with
// those of engines made for the purpose.
#include <random>

#include <gtest/gtest.h>

#include "sightline/tests/engine/drawn_grid.h"

namespace sightline::tests {
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
  const engine::Drawing* drawing = engine->drawing();
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
    EXPECT_STREQ(engine->culler_name(), name);
    EXPECT_EQ(engine->hybrid() != nullptr, choice == CullerChoice::kHybrid);
    const core::View eye = view(0.2 * round);
    for (int frame = 0; frame < 3; ++frame) {
      const auto report = engine->frame(eye);
      ASSERT_TRUE(report);
      if (!engine->hybrid()) {
        EXPECT_STREQ(report->path, name);
      }
    }
    const render::Image image = engine->drawing()->target().read_colour();
    ASSERT_TRUE(engine->set_culler(CullerChoice::kLinear) && engine->frame(eye));
    const auto difference = render::compare(image, engine->drawing()->target().read_colour());
    ASSERT_TRUE(difference);
    EXPECT_EQ(difference->max, 0);
    EXPECT_EQ(engine->drawing(), drawing) << "made anew";
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
  EXPECT_EQ(engine->drawing(), nullptr);
  const auto expected = engine->frame(view(0.3));
  ASSERT_TRUE(expected);
  ASSERT_TRUE(engine->set_culler(CullerChoice::kGpu));
  const auto report = engine->frame(view(0.3));
  ASSERT_TRUE(report);
  EXPECT_STREQ(report->path, "gpu");
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
    expect_same_picture(*engine, *fresh);
  }
  for (const auto& [width, height] : {std::pair{0, 10}, {10, -1}, {1 << 20, 10}}) {
    SCOPED_TRACE(testing::Message() << width << " x " << height);
    EXPECT_FALSE(engine->resize(width, height));
    EXPECT_EQ(engine->drawing()->target().width(), 640);
    ASSERT_TRUE(engine->frame(view(0.4)));
  }
}

TEST_F(DrawingTest, DrawsFromAsideWhatAnotherViewSees) {
  core::Scene scene;
  fill(scene, 12);
  const core::View narrow = *core::View::perspective({{-9, 5, 5}, {5, 5, 5}, {0, 0, 1}}, 0.1, 1.5, 0.1);
  const core::View aside = *core::View::perspective({{5, -40, 30}, {5, 5, 5}, {0, 0, 1}}, 0.7, 1.5, 0.1);
  auto cpu = Engine::create(scene, config(CullerChoice::kCpu));
  ASSERT_TRUE(cpu && cpu->frame(narrow));
  std::vector<bool> seen(scene.item_slots());
  for (const core::Slot slot : cpu->visible().sorted_slots()) seen[cpu->snapshot().item(slot)] = true;
  auto gpu = Engine::create(scene, config(CullerChoice::kGpu));
  ASSERT_TRUE(gpu && gpu->frame(aside, narrow));
  const auto report = cpu->frame(aside, narrow);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->visible, std::count(seen.begin(), seen.end(), true));
  EXPECT_LT(report->visible, 1000);

  for (core::ItemId item = 0; item < scene.item_slots(); ++item) scene.set_visible(item, seen[item]);
  auto expected = Engine::create(scene, config(CullerChoice::kCpu));
  ASSERT_TRUE(expected && expected->frame(aside));
  expect_same_picture(*cpu, *expected, 1);
  expect_same_picture(*gpu, *expected, 1);
}

}  // namespace
}  // namespace sightline::tests
