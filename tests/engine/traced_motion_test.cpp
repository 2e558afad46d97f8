// Moving images within a budget that rays make, beside those of an engine without a budget; and what becomes of them at
// rest.
#include <cmath>
#include <cstdint>
#include <thread>
#include <utility>

#include <gtest/gtest.h>

#include "sightline/core/scene.h"
#include "sightline/render/image/image_metrics.h"
#include "sightline/tests/engine/drawing_modes.h"

namespace sightline::tests::traced_motion_test {
namespace {

using engine::Engine;
using engine::EngineConfig;
using engine::FrameReport;

constexpr double kTooShort = 1e-3;  // ms, for any image

bool traced(const FrameReport& report) {
  return report.coarseness > 1.0 || report.earlier > 0.0;
}

class TracedMotion : public DrawnGrid, public testing::WithParamInterface<DrawingMode> {
 protected:
  static constexpr int kWidth = 190, kHeight = 130;

  void SetUp() override {
    DrawnGrid::SetUp();
    if (!context->capabilities().software) GTEST_SKIP() << "a GPU draws moving images by other means";
    fill(scene, 12);
    const core::MaterialId faded = scene.add_material({"", {0.9f, 0.6f, 0.1f}, 0.5f, 0});
    for (int i = 0; i < 6; ++i)
      scene.add_primitive(scene.root(), core::Sphere{1.5f}, core::translation({2.0 * i, 5.5, 5.5}), faded);
    for (int i = 0; i < 40; ++i)
      scene.add_primitive(scene.root(), core::Line{-9, 9}, core::translation({0.3 * i, 6, 0.25 * i}));
  }
  EngineConfig with(double budget_ms) {
    EngineConfig c = config(engine::CullerChoice::kCpu, kWidth, kHeight);
    c.drawing.ids = true;
    GetParam().set(c);
    c.losses.budget_ms = budget_ms;
    return c;
  }
  static core::View at(double turn) {
    const core::dvec3 centre(5.5), eye = centre + 16.0 * core::dvec3(std::cos(turn), std::sin(turn), 0.2);
    return *core::View::perspective({eye, centre, {0, 0, 1}}, 0.7, double(kWidth) / kHeight, 0.1);
  }
  /// A first frame is drawn as a whole, and is late. Then there are rays.
  static bool begin(Engine& engine) {
    if (!engine.frame(at(-1.0))) return false;
    while (engine.preparing_picks()) std::this_thread::yield();
    return engine.frame(at(-1.1)).has_value();
  }
  /// Shows a view until its moving image is all that rays see. Returns the report of the last frame.
  static core::Expected<FrameReport> trace_all(Engine& engine, const core::View& view) {
    auto report = engine.frame(view);
    for (int i = 0; i < 300 && report && traced(*report); ++i) report = engine.frame(view);
    return report;
  }
  /// Colours and ids differ where a ray and the rasteriser disagree about an outline, or where one surface lies in
  /// another.
  static void expect_alike(Engine& a, Engine& b, double most_flip, double most_ids) {
    const auto colours = a.read_colour(), wanted = b.read_colour();
    const auto ids = a.read_ids(), wanted_ids = b.read_ids();
    ASSERT_TRUE(colours && wanted && ids && wanted_ids);
    double flip = 0.0;
    for (const float error : image::flip(*wanted, *colours)) flip += double(error) / (kWidth * kHeight);
    EXPECT_LT(flip, most_flip);
    int other = 0;
    for (std::size_t i = 0; i < ids->ids.size(); ++i) other += ids->ids[i] != wanted_ids->ids[i];
    EXPECT_LE(other, most_ids * kWidth * kHeight);
  }

  core::Scene scene;
};

INSTANTIATE_TEST_SUITE_P(
    , TracedMotion,
    testing::Values(
        DrawingMode{"plain", [](EngineConfig&) {}},
        DrawingMode{"occlusion", [](EngineConfig& c) { c.culling.occlusion = engine::OcclusionChoice::kOn; }},
        DrawingMode{"samples", [](EngineConfig& c) { c.drawing.samples = 4; }},
        DrawingMode{"studio", [](EngineConfig& c) { c.drawing.looks.lighting = gpuprims::Lighting::kStudio; }},
        DrawingMode{"sun",
                    [](EngineConfig& c) {
                      c.drawing.looks.lighting = gpuprims::Lighting::kSun;
                      c.drawing.looks.sun = {1, -2, 3};
                      c.drawing.looks.background.top = {0.2f, 0.3f, 0.7f};
                    }}),
    name_of);

/// Where rays have met all pixels, the image is what the rasteriser draws, but for single pixels; then it becomes that.
TEST_P(TracedMotion, ShowsAllThatTheRasteriserDraws) {
  auto hurried = Engine::create(scene, with(kTooShort)), all = Engine::create(scene, with(0.0));
  ASSERT_TRUE(hurried && all);
  ASSERT_TRUE(begin(*hurried));
  const double smooth = GetParam().name == std::string("samples") ? 0.09 : 0.0;  // of edges, which rays do not smooth
  core::View view = at(0.4);
  for (const bool cut : {false, true}) {
    SCOPED_TRACE(cut ? "cut" : "whole");
    if (cut) view.sections.push_back({{0, -1, 0}, 7.1});
    const auto moving = hurried->frame(view);
    ASSERT_TRUE(moving);
    EXPECT_TRUE(traced(*moving));
    EXPECT_GT(moving->pending, 0);
    EXPECT_GT(hurried->loss(view)->coarseness, 1.0);
    EXPECT_GT(hurried->memory().tracer, all->memory().tracer + std::size_t(50 * kWidth * kHeight)) << "of its points";
    ASSERT_TRUE(trace_all(*hurried, view) && all->frame(view));
    expect_alike(*hurried, *all, 0.004 + smooth, smooth > 0.0 ? 0.1 : 0.004);
    ASSERT_TRUE(draw_complete(*hurried, view));
    if (!cut) expect_same_image(*hurried, *all);  // in section planes several items have one depth
    ASSERT_TRUE(hurried->frame(view));
    if (!cut) expect_same_image(*hurried, *all);
    expect_alike(*hurried, *all, 1e-4, 2e-4);
  }
}

/// A moving image shows nothing that was there before an edit, a new style or a hidden item.
TEST_P(TracedMotion, FollowsTheScene) {
  auto hurried = Engine::create(scene, with(kTooShort)), all = Engine::create(scene, with(0.0));
  ASSERT_TRUE(hurried && all);
  ASSERT_TRUE(begin(*hurried));
  ASSERT_TRUE(trace_all(*hurried, at(0.4)));
  std::vector<core::ItemId> red, hidden, ghosts;
  for (std::uint32_t i = 0; i < 12 * 12 * 12; i += 5)
    (i % 3 == 0 ? red : i % 3 == 1 ? hidden : ghosts).push_back(core::ItemId{i});
  for (Engine* engine : {&*hurried, &*all}) {
    ASSERT_TRUE(engine->set_override(red, {.colour = core::vec3(0.9f, 0.0f, 0.0f)}));
    ASSERT_TRUE(engine->hide(hidden));
    ASSERT_TRUE(engine->set_override(ghosts, {.ghost = true}));
  }
  const double smooth = GetParam().name == std::string("samples") ? 0.09 : 0.0;
  const auto first = hurried->frame(at(0.41));
  ASSERT_TRUE(first);
  EXPECT_EQ(first->earlier, 0.0) << "earlier frames have shown something else";
  for (const double turn : {0.42, 0.44}) {
    const auto report = trace_all(*hurried, at(turn));
    ASSERT_TRUE(report && all->frame(at(turn)));
    expect_alike(*hurried, *all, 0.004 + smooth, smooth > 0.0 ? 0.1 : 0.004);
  }
  scene.remove_item(core::ItemId{7});
  ASSERT_TRUE(hurried->commit() && all->commit());
  while (hurried->preparing_picks()) std::this_thread::yield();
  ASSERT_TRUE(hurried->frame(at(0.45)));
  const auto report = trace_all(*hurried, at(0.46));
  ASSERT_TRUE(report && all->frame(at(0.46)));
  expect_alike(*hurried, *all, 0.004 + smooth, smooth > 0.0 ? 0.1 : 0.004);
}

/// The first image of a motion shows what the image at rest has, moved.
TEST_P(TracedMotion, BeginsWithTheImageAtRest) {
  auto hurried = create_with_overlays(scene, with(kTooShort)), all = Engine::create(scene, with(0.0));
  ASSERT_TRUE(hurried && all);
  ASSERT_TRUE(begin(*hurried));
  ASSERT_TRUE(hurried->clear_overrides());
  ASSERT_TRUE(draw_complete(*hurried, at(0.4)));
  const auto report = hurried->frame(at(0.4005));
  ASSERT_TRUE(report && all->frame(at(0.4005)));
  EXPECT_GT(report->earlier, 0.8);
  EXPECT_LT(report->coarseness, 1.1);
  expect_alike(*hurried, *all, 0.25, 0.25);
}

/// Frames at rest show no image of a moving view, however much each one shifts it, before and after motion.
TEST_P(TracedMotion, IsNotTracedAtRest) {
  auto hurried = create_with_overlays(scene, with(kTooShort)), all = create_with_overlays(scene, with(0.0));
  ASSERT_TRUE(hurried && all);
  ASSERT_TRUE(begin(*hurried));
  for (const double turn : {0.4, 0.4002, 0.4004, 0.9}) {
    SCOPED_TRACE(turn);
    const core::View view = at(turn);
    if (turn == 0.4004) {
      const auto moving = hurried->frame(view);
      ASSERT_TRUE(moving);
      EXPECT_TRUE(traced(*moving));
    }
    std::int64_t pending = std::int64_t(scene.item_count()), before = pending + 1;
    while (pending > 0 && pending < before) {
      const auto report = hurried->frame({.view = view, .at_rest = true});
      ASSERT_TRUE(report);
      EXPECT_EQ(report->earlier, 0.0);
      before = std::exchange(pending, report->pending);
    }
    EXPECT_EQ(pending, 0) << "each frame draws some";
    ASSERT_TRUE(all->frame(view));
    expect_alike(*hurried, *all, 1e-4, 2e-4);  // a line may lie as deep as a surface
  }
}

/// Overlays are drawn once, while the image moves and at rest.
TEST_P(TracedMotion, IsDrawnOverOnce) {
  auto hurried = create_with_overlays(scene, with(kTooShort)), all = create_with_overlays(scene, with(0.0));
  ASSERT_TRUE(hurried && all);
  ASSERT_TRUE(begin(*hurried));
  ASSERT_TRUE(trace_all(*hurried, at(0.4)));
  ASSERT_TRUE(draw_complete(*hurried, at(0.4)) && all->frame(at(0.4)));
  for (int frame = 0; frame < 3; ++frame) {
    ASSERT_TRUE(hurried->frame(at(0.4)));
    expect_same_image(*hurried, *all);
  }
}

/// Images that an engine shows in turn follow their own cameras.
TEST_P(TracedMotion, KeepsImagesApart) {
  auto hurried = Engine::create(scene, with(kTooShort)), one = Engine::create(scene, with(kTooShort));
  ASSERT_TRUE(hurried && one);
  ASSERT_TRUE(begin(*hurried) && begin(*one));
  ASSERT_TRUE(draw_complete(*one, at(0.4)));
  for (int turn = 0; turn < 100; ++turn)
    for (const std::uint32_t image : {1u, 0u}) {
      ASSERT_TRUE(hurried->use_image(image));
      ASSERT_TRUE(hurried->frame(at(image == 0 ? 0.4 : 2.0 + 0.01 * turn)));
    }
  expect_same_image(*hurried, *one);
}

}  // namespace
}  // namespace sightline::tests::traced_motion_test
