// Several views of one engine in turn, each with an image of its own: Engine::use_image() and frames of several
// views.
#include <gtest/gtest.h>

#include "sightline/gl/external_target.h"
#include "sightline/tests/engine/application.h"
#include "sightline/tests/engine/drawn_grid.h"
#include "sightline/tests/support/simulated_gpu.h"

namespace sightline::tests::several_views_test {
namespace {

using engine::CullerChoice;
using engine::Engine;
using engine::EngineConfig;

constexpr int kWidth = 96, kHeight = 64;

class SeveralViews : public DrawnGrid {
 protected:
  void SetUp() override {
    DrawnGrid::SetUp();
    if (context) fill(scene, 22);
  }
  EngineConfig small(CullerChoice culler = CullerChoice::kCpu) { return config(culler, kWidth, kHeight); }
  static std::vector<core::View> views(int count, double turn = 0.0) {
    std::vector<core::View> made;
    for (int i = 0; i < count; ++i) made.push_back(view(turn + 1.3 * i));
    return made;
  }
  /// The image of an engine that draws nothing else.
  image::Image alone(const core::View& view, const EngineConfig& c) {
    auto engine = Engine::create(scene, c);
    EXPECT_TRUE(engine && draw_complete(*engine, view));
    return *engine->read_colour();
  }
  static void expect_image(Engine& engine, std::uint32_t number, const image::Image& expected) {
    SCOPED_TRACE(number);
    ASSERT_TRUE(engine.use_image(number));
    const auto difference = image::compare(*engine.read_colour(), expected);
    ASSERT_TRUE(difference) << difference.error().message;
    EXPECT_EQ(difference->max, 0) << difference->pixels << " pixels";
  }

  core::Scene scene;
};

/// With one image each view would begin the other's anew.
TEST_F(SeveralViews, ABudgetCompletesTheImagesOfAllThatRest) {
  const SimulatedGpu gpu(*context,
                         {.name = "slow", .triangle = 1e-5});  // software rasterisers draw coarser images instead
  for (const auto mode : {engine::ContributionMode::kDrop, engine::ContributionMode::kPoints}) {
    EngineConfig c = small();
    c.losses.contribution_mode = mode;
    EngineConfig budget = c;
    budget.losses.budget_ms = 0.5;
    auto engine = Engine::create(scene, budget);
    ASSERT_TRUE(engine);
    const std::vector<core::View> eyes = views(3);
    std::vector<Application> applications;
    std::vector<gl::ExternalTarget> targets;
    for (std::size_t i = 0; i < eyes.size(); ++i) {
      applications.emplace_back(gl(), kWidth, kHeight, kDepthModes[0]);
      targets.push_back(applications.back().target());
      targets.back().clear_colour = targets.back().clear_depth = true;
    }
    int unfinished = 0, rounds = 0;
    for (std::int64_t pending = 1; pending > 0 && rounds < 2000; ++rounds) {
      const auto reports = engine->frame(eyes, targets);
      ASSERT_TRUE(reports) << reports.error().message;
      ASSERT_EQ(reports->size(), eyes.size());
      pending = 0;
      for (const engine::FrameReport& report : *reports) pending += report.pending;
      unfinished += pending > 0;
    }
    EXPECT_GT(unfinished, 1);
    EXPECT_LT(rounds, 2000);
    for (std::uint32_t i = 0; i < eyes.size(); ++i) {
      const image::Image expected = alone(eyes[i], c);
      ASSERT_NO_FATAL_FAILURE(expect_image(*engine, i, expected));
      const auto rgba = applications[i].pixels();
      for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x)
          for (int k = 0; k < 3; ++k)
            ASSERT_EQ(rgba[std::size_t(4 * (y * kWidth + x) + k)],
                      expected.pixels[std::size_t(3 * ((kHeight - 1 - y) * kWidth + x) + k)]);
    }
  }
}

/// Hysteresis and what was seen belong to a view: each image is that of an engine which has no other.
TEST_F(SeveralViews, EachIsAsInAnEngineOfItsOwn) {
  for (const CullerChoice culler : {CullerChoice::kCpu, CullerChoice::kGpu}) {
    EngineConfig c = small(culler);
    c.culling.occlusion = engine::OcclusionChoice::kOn;
    if (culler == CullerChoice::kCpu) c.losses.min_projected_area = 20.0f;
    auto shared = Engine::create(scene, c);
    ASSERT_TRUE(shared);
    std::vector<Engine> own;
    for (int i = 0; i < 3; ++i) own.push_back(*Engine::create(scene, c));
    for (int i = 1; i < 3; ++i) {
      ASSERT_TRUE(shared->use_image(std::uint32_t(i)));
      ASSERT_TRUE(shared->resize(kWidth + 32 * i, kHeight + 16 * i));
      ASSERT_TRUE(own[std::size_t(i)].resize(kWidth + 32 * i, kHeight + 16 * i));
    }
    for (int round = 0; round < 12; ++round) {
      const auto eyes = views(3, 0.02 * round);
      if (round == 6) {
        for (core::ItemId item{0}; to_index(item) < 3000; item = core::ItemId{to_index(item) + 3})
          scene.set_visible(item, false);
        ASSERT_TRUE(shared->commit());
        for (Engine& engine : own) ASSERT_TRUE(engine.commit());
      }
      ASSERT_TRUE(round != 9 || (shared->rebuild() && own[0].rebuild() && own[1].rebuild() && own[2].rebuild()));
      for (std::uint32_t i = 0; i < 3; ++i) {
        ASSERT_TRUE(shared->use_image(i));
        const auto report = shared->frame(eyes[i]), expected = own[i].frame(eyes[i]);
        ASSERT_TRUE(report && expected);
        EXPECT_EQ(report->below_min_area, expected->below_min_area);
        EXPECT_EQ(report->items_drawn, expected->items_drawn) << "image " << i << ", round " << round;
        ASSERT_NO_FATAL_FAILURE(expect_image(*shared, i, *own[i].read_colour()));
      }
    }
  }
}

TEST_F(SeveralViews, AnImageKeepsItsSizeThroughALoss) {
  auto engine = Engine::create(scene, small());
  ASSERT_TRUE(engine && engine->use_image(7) && engine->resize(40, 30) && engine->frame(view(1.0, 4.0 / 3.0)));
  const image::Image before = *engine->read_colour();
  engine->drop_context();
  ASSERT_TRUE(engine->use_image(0));
  EXPECT_EQ(engine->config().width, kWidth);
  ASSERT_TRUE(engine->use_image(7));
  EXPECT_EQ(engine->config().width, 40);
  ASSERT_TRUE(context->make_current() && engine->use_context(*context) && engine->frame(view(1.0, 4.0 / 3.0)));
  ASSERT_NO_FATAL_FAILURE(expect_image(*engine, 7, before));
  ASSERT_TRUE(engine->use_image(0) && engine->frame(view(1.0)));
  ASSERT_NO_FATAL_FAILURE(expect_image(*engine, 0, alone(view(1.0), small())));
}

TEST_F(SeveralViews, AnEditShowsInAllImages) {
  EngineConfig c = small();
  c.losses.budget_ms = 1000.0;
  auto engine = Engine::create(scene, c);
  ASSERT_TRUE(engine);
  const auto eyes = views(2);
  const auto draw_both = [&] {
    for (std::uint32_t i = 0; i < 2; ++i) ASSERT_TRUE(engine->use_image(i) && draw_complete(*engine, eyes[i]));
  };
  for (int round = 0; round < 3; ++round) ASSERT_NO_FATAL_FAILURE(draw_both());  // complete: frames draw nothing
  std::vector<core::ItemId> all;
  for (core::ItemId item{0}; to_index(item) < 5000; ++item) all.push_back(item);
  ASSERT_TRUE(engine->set_override(all, {.colour = core::vec3(1, 0, 0)}));
  ASSERT_NO_FATAL_FAILURE(draw_both());
  for (std::uint32_t i = 0; i < 2; ++i) {
    auto fresh = Engine::create(scene, small());
    ASSERT_TRUE(fresh && fresh->set_override(all, {.colour = core::vec3(1, 0, 0)}) && fresh->frame(eyes[i]));
    ASSERT_NO_FATAL_FAILURE(expect_image(*engine, i, *fresh->read_colour()));
  }
}

TEST_F(SeveralViews, MemoryIsThatOfTheImagesThereAre) {
  auto engine = Engine::create(scene, small());
  ASSERT_TRUE(engine && engine->frame(view(0.0)));
  const std::size_t one = engine->memory().gpu;
  ASSERT_TRUE(engine->use_image(3) && engine->frame(view(1.0)));
  EXPECT_GE(engine->memory().gpu, one + 8 * kWidth * kHeight);
  ASSERT_TRUE(engine->use_image(0));
  EXPECT_FALSE(engine->forget_image(0));
  EXPECT_TRUE(engine->forget_image(3));
  EXPECT_TRUE(engine->forget_image(12)) << "which never was";
  EXPECT_EQ(engine->memory().gpu, one);
}

TEST_F(SeveralViews, WhatDoesNotFitIsRefused) {
  auto engine = Engine::create(scene, small());
  ASSERT_TRUE(engine);
  const Application application(gl(), kWidth, kHeight, kDepthModes[0]);
  const auto eyes = views(2);
  const gl::ExternalTarget target = application.target();
  const auto few = engine->frame(eyes, {&target, 1});
  ASSERT_FALSE(few);
  EXPECT_NE(few.error().message.find("as many targets as views"), std::string::npos) << few.error().message;
  gl::ExternalTarget huge = target;
  huge.width = 1 << 28;
  const gl::ExternalTarget targets[] = {target, huge};
  ASSERT_TRUE(engine->use_image(5));
  EXPECT_FALSE(engine->frame(eyes, targets));
  EXPECT_EQ(engine->config().width, kWidth);
  ASSERT_TRUE(engine->frame(eyes[1]));
  ASSERT_NO_FATAL_FAILURE(expect_image(*engine, 5, alone(eyes[1], small())));
  EXPECT_TRUE(engine->frame(std::span<const core::View>(), {})->empty());
}

}  // namespace
}  // namespace sightline::tests::several_views_test
