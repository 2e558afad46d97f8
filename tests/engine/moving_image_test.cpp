// Moving images within a budget on a software rasteriser that are not traced: all of the scene with fewer pixels, beside the image of an
// engine that has no more; and what becomes of them at rest.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "sightline/core/scene.h"
#include "sightline/engine/drawing/internal/moving_resolution.h"
#include "sightline/engine/internal/engine_parts.h"
#include "sightline/tests/engine/drawing_modes.h"

namespace sightline::tests::moving_image_test {
namespace {

using engine::Engine;
using engine::EngineConfig;
using engine::MovingResolution;

constexpr double kTooShort = 1e-3;  // ms, for any image
constexpr double kMost = MovingResolution::kSteps.back();

// --- which resolution ------------------------------------------------------------------------------------------------

TEST(MovingResolution, BeginsByTheNumberOfItems) {
  MovingResolution few, many;
  few.begin(100);
  many.begin(1'000'000);
  EXPECT_EQ(few.coarseness(), 1.0);
  EXPECT_EQ(many.coarseness(), kMost);
  many.took(1.0, 33.0);
  const double learnt = many.coarseness();
  many.begin(100);
  EXPECT_EQ(many.coarseness(), learnt) << "what is measured counts from then on";
}

/// A machine that takes so long for all pixels, and less by the power of a coarser step: the time settles within the
/// budget, at a step next to which a finer one would not be in time.
TEST(MovingResolution, SettlesAtTheFinestStepInTime) {
  for (const double all_ms : {5.0, 40.0, 80.0, 160.0, 400.0, 4000.0}) {
    SCOPED_TRACE(testing::Message() << all_ms << " ms with all pixels");
    constexpr double kBudget = 33.0;
    const auto ms = [&](std::size_t step) { return all_ms * std::pow(MovingResolution::kSteps[step], -1.3); };
    MovingResolution resolution;
    resolution.begin(100);
    int changes = 0;
    for (int frame = 0; frame < 100; ++frame) {
      const std::size_t before = resolution.step();
      resolution.took(ms(before), kBudget);
      changes += frame > 30 && resolution.step() != before;
    }
    EXPECT_EQ(changes, 0) << "flickers";
    const std::size_t step = resolution.step();
    EXPECT_TRUE(ms(step) <= kBudget || resolution.coarseness() == kMost);
    if (step > 0) {
      EXPECT_GT(ms(step - 1), 0.84 * kBudget);
    }
  }
}

TEST(MovingResolution, OneLateFrameMakesTheNextOneCoarserAtOnce) {
  MovingResolution resolution;
  resolution.begin(100);
  resolution.took(300.0, 33.0);
  EXPECT_EQ(resolution.coarseness(), kMost);
  for (int frame = 0; frame < 3; ++frame) {
    resolution.took(1.0, 33.0);
    EXPECT_EQ(resolution.coarseness(), kMost) << "one frame in time is no reason";
  }
  resolution.took(1.0, 33.0);
  EXPECT_LT(resolution.coarseness(), kMost);
}

// --- images ----------------------------------------------------------------------------------------------------------

class MovingImage : public DrawnGrid, public testing::WithParamInterface<DrawingMode> {
 protected:
  static constexpr int kWidth = 190, kHeight = 130;

  void SetUp() override {
    DrawnGrid::SetUp();
    fill(scene, 18);
  }
  EngineConfig with(double budget_ms, double coarseness = 1.0) {
    EngineConfig c = config(engine::CullerChoice::kCpu, int(std::lround(kWidth / coarseness)),
                            int(std::lround(kHeight / coarseness)));
    c.drawing.ids = true;
    GetParam().set(c);
    c.losses.budget_ms = budget_ms;
    return c;
  }
  /// A view of an engine whose first frame, which is not known to be late, is done.
  core::Expected<engine::FrameReport> moved(Engine& engine, const core::View& to) {
    engine::EngineParts::set_traces_motion(engine, false);
    if (auto first = engine.frame(view(-1.0)); !first) return first;
    return engine.frame(to);
  }

  core::Scene scene;
};

INSTANTIATE_TEST_SUITE_P(, MovingImage,
                         testing::Values(DrawingMode{"plain", [](EngineConfig&) {}},
                                         DrawingMode{"occlusion",
                                                     [](EngineConfig& c) {
                                                       c.culling.occlusion = engine::OcclusionChoice::kOn;
                                                     }},
                                         DrawingMode{"samples", [](EngineConfig& c) { c.drawing.samples = 4; }},
                                         DrawingMode{"small_items",
                                                     [](EngineConfig& c) {
                                                       c.losses.min_projected_area = 12.0f;
                                                       c.losses.contribution_mode = engine::ContributionMode::kPoints;
                                                     }}),
                         name_of);

/// Each pixel has the item and the depth of an image with fewer pixels, and a colour between its colours.
TEST_P(MovingImage, IsThatOfFewerPixels) {
  EngineConfig fewer = with(0.0, kMost);
  fewer.losses.min_projected_area *= float(fewer.width * fewer.height) / float(kWidth * kHeight);
  auto hurried = Engine::create(scene, with(kTooShort)), small = Engine::create(scene, fewer);
  ASSERT_TRUE(hurried && small);
  const core::View at = view(0.4);
  const auto report = moved(*hurried, at);
  ASSERT_TRUE(report && moved(*small, at));
  EXPECT_EQ(report->coarseness, kMost);
  EXPECT_GT(report->pending, 0);
  const auto colours = hurried->read_colour(), small_colours = small->read_colour();
  const auto ids = hurried->read_ids(), small_ids = small->read_ids();
  ASSERT_TRUE(colours && small_colours && ids && small_ids);
  int other = 0, outside = 0;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      // Rows of images begin at the top, those of GL at the bottom.
      const double u = (x + 0.5) * small_ids->width / kWidth;
      const double v = small_ids->height - (kHeight - y - 0.5) * small_ids->height / kHeight;
      const auto pixel = [&](int column, int row) {
        return std::size_t(std::clamp(row, 0, small_ids->height - 1)) * std::size_t(small_ids->width) +
               std::size_t(std::clamp(column, 0, small_ids->width - 1));
      };
      const std::size_t here = std::size_t(y) * kWidth + std::size_t(x);
      const bool on_border = std::abs(u - std::round(u)) < 1e-3 || std::abs(v - std::round(v)) < 1e-3;
      if (!on_border) other += ids->ids[here] != small_ids->ids[pixel(int(u), int(v))];
      for (std::size_t c = 0; c < 3; ++c) {
        int least = 255, most = 0;
        for (const int row : {int(std::floor(v - 0.5)), int(std::floor(v - 0.5)) + 1})
          for (const int column : {int(std::floor(u - 0.5)), int(std::floor(u - 0.5)) + 1}) {
            const int channel = small_colours->pixels[3 * pixel(column, row) + c];
            least = std::min(least, channel), most = std::max(most, channel);
          }
        const int channel = colours->pixels[3 * here + c];
        outside += channel < least - 1 || channel > most + 1;
      }
    }
  EXPECT_EQ(other, 0);
  EXPECT_EQ(outside, 0);
  const auto loss = hurried->loss(at);
  ASSERT_TRUE(loss);
  EXPECT_EQ(loss->coarseness, kMost);
}

/// The coarse image stays until that with all pixels is complete, which is the one that an engine without a budget
/// draws; then frames draw nothing.
TEST_P(MovingImage, BecomesTheCompleteOneAtRest) {
  auto hurried = Engine::create(scene, with(kTooShort)), all = Engine::create(scene, with(0.0));
  ASSERT_TRUE(hurried && all);
  const core::View at = view(0.4);
  ASSERT_TRUE(moved(*hurried, at) && moved(*all, at));
  const auto coarse = hurried->read_colour();
  ASSERT_TRUE(coarse);
  auto report = hurried->frame(at);
  for (int i = 0; i < 1000 && report && report->pending > 0; ++i) {
    EXPECT_EQ(report->coarseness, kMost);
    EXPECT_EQ(hurried->read_colour()->pixels, coarse->pixels);
    report = hurried->frame(at);
  }
  ASSERT_TRUE(report);
  EXPECT_EQ(report->coarseness, 1.0);
  EXPECT_EQ(hurried->loss(at)->coarseness, 1.0);
  expect_same_image(*hurried, *all);
  ASSERT_TRUE(hurried->frame(at));
  expect_same_image(*hurried, *all);
}

/// A frame that shows culling from the side is not drawn coarsely, and shows nothing of a coarse one before it.
TEST_P(MovingImage, IsForgottenByFramesThatShowCulling) {
  auto hurried = Engine::create(scene, with(kTooShort));
  ASSERT_TRUE(hurried);
  const core::View at = view(0.4), aside = view(2.0);
  const auto coarse = moved(*hurried, at);
  ASSERT_TRUE(coarse);
  EXPECT_EQ(coarse->coarseness, kMost);
  const auto report = hurried->frame({.view = aside, .cull_view = &at});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->coarseness, 1.0);
}

/// What is drawn over an image is drawn once, at rest too, whether the moving image had all pixels or not.
TEST_P(MovingImage, IsDrawnOverOnce) {
  for (const double budget_ms : {kTooShort, 1e5}) {
    SCOPED_TRACE(testing::Message() << budget_ms << " ms");
    auto hurried = create_with_overlays(scene, with(budget_ms)), all = create_with_overlays(scene, with(0.0));
    ASSERT_TRUE(hurried && all);
    const core::View at = view(0.4);
    ASSERT_TRUE(moved(*hurried, at) && draw_complete(*hurried, at) && moved(*all, at));
    for (int frame = 0; frame < 3; ++frame) {
      ASSERT_TRUE(hurried->frame(at));
      expect_same_image(*hurried, *all);
    }
  }
}

}  // namespace
}  // namespace sightline::tests::moving_image_test
