// The hybrid: whichever path culls a frame, the image is the same; a small scene gets no GPU culler; edits and a GPU
// that fails are survived.
#include "sightline/engine/internal/hybrid.h"

#include <cstdio>

#include <gtest/gtest.h>

#include "sightline/engine/internal/engine_parts.h"
#include "sightline/gl/internal/timer.h"
#include "sightline/tests/culling/scenes.h"
#include "sightline/tests/engine/drawn_grid.h"

namespace sightline::tests::hybrid_test {
namespace {

using engine::CullerChoice;
using engine::Engine;
using engine::EngineConfig;

class HybridTest : public DrawnGrid {
 protected:
  EngineConfig config(CullerChoice culler) {
    EngineConfig c = DrawnGrid::config(culler);
    c.drawing.ids = true;
    switch_often(c);
    return c;
  }
};

TEST_F(HybridTest, ASwitchChangesNoPixel) {
  core::Scene scene;
  fill(scene, 22);
  auto cpu = Engine::create(scene, config(CullerChoice::kCpu));
  auto hybrid = Engine::create(scene, config(CullerChoice::kHybrid));
  ASSERT_TRUE(cpu && hybrid) << (cpu ? hybrid.error().message : cpu.error().message);
  ASSERT_EQ(name_of(hybrid->plan().culler), "hybrid");
  constexpr int kEdit = 8;
  int frames_on[2] = {0, 0};
  for (int frame = 0; frame < 18; ++frame) {
    SCOPED_TRACE(testing::Message() << "frame " << frame);
    if (frame == kEdit) {
      for (core::ItemId item{0}; to_index(item) < 300; ++item)
        scene.set_visible(core::ItemId{to_index(item) * 7}, false);
      for (int i = 0; i < 40; ++i)
        scene.add_primitive(scene.root(), core::Box{0.5f, 0.5f, 0.5f}, core::translation({0.5 * i, 11.5, 12.5}));
      ASSERT_TRUE(hybrid->commit());
      ASSERT_TRUE(cpu->rebuild());
    }
    const auto a = cpu->frame(view(0.1 * frame)), b = hybrid->frame(view(0.1 * frame));
    ASSERT_TRUE(a && b);
    const bool gpu = b->culler == CullerChoice::kGpu;
    ++frames_on[gpu];
    EXPECT_EQ(b->visible < 0, gpu);
    SCOPED_TRACE(name_of(b->culler));
    expect_same_image(*cpu, *hybrid, frame < kEdit ? 0 : 1);
  }
  EXPECT_GE(frames_on[0], 4);
  EXPECT_GE(frames_on[1], 4);
  EXPECT_GE(hybrid->controller()->switches(), 1u);
  int late = 0;
  while (const auto report = hybrid->take_late_report()) {
    EXPECT_GT(report->visible, 0);
    ++late;
  }
  EXPECT_GT(late, 0);
}

/// Frames that show what is hidden are the CPU's, and the path that follows is as if there had been none.
TEST_F(HybridTest, FramesFromAsideTeachItNothing) {
  core::Scene scene;
  fill(scene, 22);
  EngineConfig c = config(CullerChoice::kHybrid);
  c.drawing.culled_colour = core::vec3(0, 0, 1);
  auto engine = Engine::create(scene, c);
  ASSERT_TRUE(engine);
  int on_gpu = 0;
  for (int round = 0; round < 3; ++round) {
    for (int i = 0; i < 8; ++i) {
      const auto report = engine->frame(view(0.1 * i));
      ASSERT_TRUE(report);
      on_gpu += report->culler == CullerChoice::kGpu;
    }
    const std::uint64_t frames = engine->controller()->frames();
    for (int i = 0; i < 2; ++i) {
      const core::View cull_view = view(0.1 * round);
      const auto aside = engine->frame({.view = view(2.0), .cull_view = &cull_view});
      ASSERT_TRUE(aside);
      EXPECT_EQ(name_of(aside->culler), "cpu");
      EXPECT_TRUE(aside->state);
    }
    EXPECT_EQ(engine->controller()->frames(), frames);
  }
  EXPECT_GT(on_gpu, 0);
}

TEST_F(HybridTest, ASmallSceneGetsNoGpuCuller) {
  core::Scene scene;
  fill(scene, 9);
  auto plain = Engine::create(scene, config(CullerChoice::kCpu));
  auto hybrid = Engine::create(scene, config(CullerChoice::kHybrid));
  ASSERT_TRUE(plain && hybrid);
  EXPECT_EQ(name_of(hybrid->plan().culler), "cpu");
  EXPECT_EQ(hybrid->controller(), nullptr);
  EXPECT_EQ(engine::EngineParts::drawing(*hybrid)->gpu_culler(), nullptr);
  EXPECT_EQ(hybrid->memory().gpu, plain->memory().gpu);
  for (const engine::PlanEntry& entry : hybrid->plan().entries)
    if (entry.feature == "GPU culler" || entry.feature == "hybrid controller") {
      EXPECT_FALSE(entry.used) << entry.feature;
      EXPECT_NE(entry.why.find("too few"), std::string::npos) << entry.why;
    }
}

/// The plan changes with the number of items: a scene that grows gets its GPU culler with the new scene version.
TEST_F(HybridTest, AHybridOfASceneThatGrows) {
  core::Scene small;
  for (int i = 0; i < 9000; ++i)
    small.add_primitive(small.root(), core::Box{0.4f, 0.4f, 0.4f}, core::translation({i % 30, i / 30 % 30, i / 900}));
  for (const bool draw : {false, true}) {
    EngineConfig c = config(CullerChoice::kHybrid);
    c.draw = draw;
    auto engine = Engine::create(small, c);
    ASSERT_TRUE(engine);
    EXPECT_EQ(engine->controller(), nullptr);
    for (int i = 0; i < 20; ++i) ASSERT_TRUE(engine->frame(view(i)));
    std::vector<core::ItemId> added;
    for (int i = 0; i < 2000; ++i)
      added.push_back(small.add_primitive(small.root(), core::Box{1, 1, 1}, core::translation({i % 40, i / 40, 30})));
    ASSERT_TRUE(engine->rebuild());
    ASSERT_NE(engine->controller(), nullptr);
    int on_gpu = 0, late = 0;
    for (int i = 0; i < 12; ++i) on_gpu += engine->frame(view(i))->culler == CullerChoice::kGpu;
    engine->finish();
    context->functions().Finish();
    while (const auto report = engine->take_late_report()) {
      EXPECT_GE(report->frame, 20u);
      ++late;
    }
    EXPECT_GT(on_gpu, 0);
    EXPECT_GT(late, 0);
    for (const core::ItemId item : added) small.remove_item(item);
    ASSERT_TRUE(engine->rebuild());
    EXPECT_EQ(engine->controller(), nullptr);
    EXPECT_EQ(engine::EngineParts::drawing(*engine) != nullptr, draw);
    ASSERT_TRUE(engine->frame(view(0)));
  }
}

TEST_F(HybridTest, GivesAGpuWithoutTimesUp) {
  core::Scene scene;
  fill(scene, 22);
  EngineConfig c = config(CullerChoice::kHybrid);
  c.draw = false;  // cull times count, and a software rasteriser has none
  c.culling.controller = {};
  auto hybrid = Engine::create(scene, c);
  ASSERT_TRUE(hybrid);
  if (!context->capabilities().software) GTEST_SKIP() << "the GPU measures its times";
  int on_gpu = 0;
  for (int frame = 0; frame < 60; ++frame) {
    const auto report = hybrid->frame(view(0.1 * frame));
    ASSERT_TRUE(report);
    on_gpu += report->culler == CullerChoice::kGpu;
  }
  EXPECT_LE(on_gpu, 30);
}

/// The last 64 of late reports that nobody takes are kept.
TEST_F(HybridTest, TheOldestLateReportsAreLost) {
  core::Scene scene;
  fill(scene, 22);
  EngineConfig c = config(CullerChoice::kGpu);
  c.draw = false;
  auto engine = Engine::create(scene, c);
  ASSERT_TRUE(engine);
  std::uint64_t last = 0;
  for (int frame = 0; frame < 120; ++frame) {
    const auto report = engine->frame(view(0.05 * frame));
    ASSERT_TRUE(report);
    context->functions().Finish();
    ASSERT_EQ(report->culler, CullerChoice::kGpu);
    last = report->frame;
  }
  // Some drivers give the results of the last frames only to those who ask again, and these come on top.
  std::vector<std::uint64_t> frames;
  for (int tries = 0; tries < 10 && (frames.empty() || frames.back() != last); ++tries)
    while (const auto report = engine->take_late_report()) frames.push_back(report->frame);
  ASSERT_GE(frames.size(), 64u);
  EXPECT_LE(frames.size(), 64u + gl::GpuTimer::kSlots);
  EXPECT_EQ(frames.back(), last);
  for (std::size_t i = 1; i < frames.size(); ++i) EXPECT_EQ(frames[i], frames[i - 1] + 1);
}

/// A GPU that has no memory left costs the hybrid nothing but its GPU path; who asked for the GPU is told.
TEST_F(HybridTest, AGpuCullerThatFails) {
  core::Scene scene;
  fill(scene, 22);
  const auto get_error = context->functions().GetError;
  auto& gl = const_cast<gl::Functions&>(context->functions());
  for (const CullerChoice culler : {CullerChoice::kHybrid, CullerChoice::kGpu}) {
    EngineConfig c = config(culler);
    c.draw = false;
    auto engine = Engine::create(scene, c), cpu = Engine::create(scene, config(CullerChoice::kCpu));
    ASSERT_TRUE(engine && cpu);
    const auto expected = cpu->frame(view(0));
    ASSERT_TRUE(expected);
    gl.GetError = []() -> GLenum { return GL_OUT_OF_MEMORY; };
    core::Expected<engine::FrameReport> report;
    for (int frame = 0; frame < 8 && report; ++frame) {
      report = engine->frame(view(0));
      if (!report) break;
      EXPECT_EQ(name_of(report->culler), "cpu");
      EXPECT_EQ(report->visible, expected->visible);
    }
    gl.GetError = get_error;
    EXPECT_EQ(bool(report), culler == CullerChoice::kHybrid) << (report ? "" : report.error().message);
    for (int frame = 0; frame < 12 && culler == CullerChoice::kHybrid; ++frame)
      EXPECT_EQ(name_of(engine->frame(view(0))->culler), "cpu") << "it does not try again";
  }
}

/// Looks cost both paths the same, so that a hybrid need not learn anew, nor a new scene version begin again.
TEST_F(HybridTest, KeepsWhatItKnowsWhenOnlyStylesChange) {
  core::Scene scene;
  fill(scene, 22);
  auto engine = Engine::create(scene, config(CullerChoice::kHybrid));
  ASSERT_TRUE(engine) << engine.error().message;
  const auto configure = [&](auto&& change) {
    EngineConfig changed = engine->config();
    change(changed);
    const auto done = engine->configure(changed);
    EXPECT_TRUE(done) << done.error().message;
    return engine->controller() ? engine->controller()->frames() : 0;
  };
  const auto learn = [&] {
    for (int frame = 0; frame < 8; ++frame) ASSERT_TRUE(engine->frame(view(0.1 * frame)));
  };
  ASSERT_NO_FATAL_FAILURE(learn());
  EXPECT_EQ(configure([](EngineConfig& c) { c.drawing.outline_colour = {0, 1, 0}; }), 8u);
  EXPECT_EQ(configure([](EngineConfig& c) { c.drawing.looks.depth_shading = {0.5f, 0.5f}; }), 8u);
  EXPECT_EQ(configure([](EngineConfig& c) { c.drawing.culled_colour = core::vec3(0, 0, 1); }), 8u);
  EXPECT_EQ(configure([](EngineConfig&) {}), 8u);
  EXPECT_EQ(configure([](EngineConfig& c) { c.culling.controller.silent_frames = 17; }), 0u);
  ASSERT_NO_FATAL_FAILURE(learn());
  EXPECT_EQ(configure([](EngineConfig& c) { c.culling.sample_test = false; }), 0u);
  ASSERT_NO_FATAL_FAILURE(learn());
  EXPECT_EQ(configure([](EngineConfig& c) { c.culling.occlusion = engine::OcclusionChoice::kOff; }), 0u);
  ASSERT_NO_FATAL_FAILURE(learn());
  EXPECT_EQ(configure([](EngineConfig& c) { c.losses.min_projected_area = 1.0f; }), 0u);
  EXPECT_EQ(engine->controller(), nullptr);
  configure([](EngineConfig& c) { c.losses.min_projected_area = 0.0f; });
  EXPECT_NE(engine->controller(), nullptr);
}

/// What lands is as the settings say by then, though they have changed since the rebuild began.
TEST_F(HybridTest, ARebuildGoesOnWhenOnlyStylesChange) {
  core::Scene scene;
  fill(scene, 30);
  auto engine = Engine::create(scene, config(CullerChoice::kHybrid));
  ASSERT_TRUE(engine) << engine.error().message;
  const std::uint64_t generation = engine->snapshot().generation();
  for (core::ItemId item{0}; to_index(item) < 2000; ++item) scene.remove_item(item);
  ASSERT_TRUE(engine->commit());
  ASSERT_TRUE(engine->rebuilding());
  EngineConfig changed = engine->config();
  changed.drawing.looks.depth_shading = {0.5f, 0.0f};
  changed.drawing.outline_colour = {0, 1, 0};
  ASSERT_TRUE(engine->configure(changed));
  while (engine->rebuilding()) ASSERT_TRUE(engine->frame(view(0)));
  EXPECT_NE(engine->snapshot().generation(), generation) << "the new scene version has landed";
  const auto used = [&](std::string_view feature) {
    return std::any_of(engine->plan().entries.begin(), engine->plan().entries.end(),
                       [&](const engine::PlanEntry& entry) { return entry.feature == feature && entry.used; });
  };
  EXPECT_TRUE(used("depth shading"));
  EXPECT_EQ(engine->plan().culler, CullerChoice::kHybrid);

  for (core::ItemId item{2000}; to_index(item) < 6000; ++item) scene.remove_item(item);
  ASSERT_TRUE(engine->commit());
  ASSERT_TRUE(engine->rebuilding());
  ASSERT_TRUE(engine->set_culler(CullerChoice::kLinear));
  EXPECT_FALSE(engine->rebuilding()) << "it would bring another culler";
}

/// Nothing to cull with on the GPU: a hybrid that comes then begins on the CPU, and takes the GPU when it is there.
TEST_F(HybridTest, AHybridWithoutAContextWaitsForOne) {
  core::Scene scene;
  fill(scene, 22);
  auto engine = Engine::create(scene, config(CullerChoice::kCpu));
  ASSERT_TRUE(engine && engine->frame(view(0)));
  engine->drop_context();
  ASSERT_TRUE(engine->set_culler(CullerChoice::kHybrid));
  ASSERT_NE(engine->controller(), nullptr);
  const auto on_gpu = [&] {
    int frames = 0;
    for (int frame = 0; frame < 12; ++frame) {
      const auto report = engine->frame(view(0.1 * frame));
      EXPECT_TRUE(report);
      frames += report->culler == CullerChoice::kGpu;
    }
    return frames;
  };
  EXPECT_EQ(on_gpu(), 0);
  ASSERT_TRUE(engine->rebuild());
  EXPECT_EQ(on_gpu(), 0);
  ASSERT_TRUE(engine->use_context(*context));
  EXPECT_GT(on_gpu(), 0);
}

/// Frames before the hybrid's first are none of its business, whatever they measured; its first is.
TEST(Hybrid, CountsFromItsFirstFrame) {
  constexpr std::uint64_t kFirst = 1000;
  const auto path_after = [](std::uint64_t reported) {
    engine::Hybrid hybrid({}, 1'000'000, kFirst);
    EXPECT_EQ(hybrid.next(0.0), culling::CullPath::kCpu);
    hybrid.measured(engine::FrameReport{.frame = kFirst, .cull_ms = 50.0, .drawn = true, .visible = 900'000});
    hybrid.drawn(reported, 60.0);
    return hybrid.next(70.0);
  };
  EXPECT_EQ(path_after(kFirst), culling::CullPath::kGpu) << "measured, so that the other path is probed";
  constexpr std::uint64_t kRound = culling::kOldestSample;
  for (const std::uint64_t other : {kFirst - 1, kFirst + 1, kFirst - kRound, kFirst + kRound, std::uint64_t(0)})
    EXPECT_EQ(path_after(other), culling::CullPath::kCpu) << other;
}

/// The variant of the GPU culler is measured once, or is the one asked for; the plan tells, also after a rebuild.
TEST_F(HybridTest, TheFormOfTheGpuCullerIsKept) {
  core::Scene scene;
  fill(scene, 22);
  EngineConfig any = config(CullerChoice::kGpu), named = any;
  named.culling.gpu_variant = culling::GpuVariant::kCompute;
  for (const EngineConfig& c : {any, named}) {
    auto engine = Engine::create(scene, c);
    ASSERT_TRUE(engine) << engine.error().message;
    const culling::GpuVariant variant = engine::EngineParts::drawing(*engine)->gpu_culler()->variant();
    const auto told = [&](std::string_view feature) -> engine::PlanEntry {
      for (const auto& entry : engine->plan().entries)
        if (entry.feature == feature) return entry;
      return {};
    };
    const engine::PlanEntry before = told("GPU culling in compute shaders");
    EXPECT_EQ(before.used, variant == culling::GpuVariant::kCompute);
    EXPECT_EQ(before.used, !told("GPU culling in geometry shaders").used);
    EXPECT_TRUE(before.why.starts_with(c.culling.gpu_variant ? "asked for" : "measured: ")) << before.why;
    if (!c.culling.gpu_variant) {
      double geometry = 0.0, compute = 0.0;
      ASSERT_EQ(std::sscanf(before.why.c_str(), "measured: geometry %lf ms, compute %lf ms", &geometry, &compute), 2);
      EXPECT_TRUE(geometry == compute || before.used == (compute < geometry)) << "the slower one: " << before.why;
    }
    ASSERT_TRUE(engine->rebuild());
    EXPECT_EQ(engine::EngineParts::drawing(*engine)->gpu_culler()->variant(), variant);
    EXPECT_EQ(told("GPU culling in compute shaders").why, before.why);
  }
  // Nothing can be measured without items, so that waits until there are some.
  core::Scene growing;
  auto engine = Engine::create(growing, any);
  ASSERT_TRUE(engine) << engine.error().message;
  EXPECT_TRUE(engine::EngineParts::drawing(*engine)->report().why_gpu_variant.starts_with("not measured: "));
  fill(growing, 5);
  ASSERT_TRUE(engine->commit());
  EXPECT_TRUE(engine::EngineParts::drawing(*engine)->report().why_gpu_variant.starts_with("measured: "))
      << engine::EngineParts::drawing(*engine)->report().why_gpu_variant;
}

/// A GPU that is the slower of the two is waited for two frames later, when another path may have been taken: the frame
/// that was drawn pays, and not the one that waited.
TEST(Hybrid, ChargesTheFrameThatKeptTheGpuBusy) {
  constexpr std::uint64_t kFrames = 240;
  int wrong = 0;
  for (const double gpu_path : {0.85, 1.15})  // of the CPU's
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      Random random(seed);
      engine::Hybrid hybrid({}, 1'000'000, 0);
      double now = 0.0, began = 0.0, free = 0.0;  // the GPU is free from then on
      std::vector<double> submitted, drawn;
      for (std::uint64_t frame = 0; frame < kFrames; ++frame) {
        const bool gpu = hybrid.next(frame > 0 ? now - began : 0.0) == culling::CullPath::kGpu;
        wrong += gpu == (gpu_path > 1.0);
        began = now;
        const auto visible = [](std::uint64_t f) { return std::int64_t(64) << (f / 20); };
        engine::FrameReport report{
            .frame = frame, .cull_ms = 0.1, .drawn = true, .visible = visible(frame), .tested = 3000};
        if (frame >= 2) {
          report.wait_ms = std::max(0.0, drawn[frame - 2] - now);
          now += report.wait_ms;
          const double before = frame >= 3 ? drawn[frame - 3] : 0.0;
          hybrid.drawn(frame - 2, drawn[frame - 2] - std::max(before, submitted[frame - 2]));
          hybrid.measured(engine::LateReport{frame - 2, visible(frame - 2), 0.1});
        }
        now += 1.0;
        submitted.push_back(now);
        free = std::max(free, now) + 10.0 * (gpu ? gpu_path : 1.0) * uniform(random, 0.97, 1.03);
        drawn.push_back(free);
        hybrid.measured(report);
      }
    }
  EXPECT_LT(wrong, int(20 * kFrames) / 12);
}

/// A hybrid that comes late counts frames from where it comes.
TEST(Hybrid, LearnsTheSameWhereverItBegins) {
  constexpr std::uint64_t kFirst = 12345;
  engine::Hybrid early({}, 1'000'000, 0), late({}, 1'000'000, kFirst);
  late.measured(engine::LateReport{kFirst - 1, 10, 0.1});  // of the GPU culler before it
  int on_gpu = 0;
  double interval = 0.0;
  for (std::uint64_t frame = 0; frame < 300; ++frame) {
    const auto a = early.next(interval), b = late.next(interval);
    ASSERT_EQ(a, b) << "frame " << frame;
    const bool gpu = a == culling::CullPath::kGpu;
    on_gpu += gpu;
    interval = gpu ? 2.0 : 9.0;
    engine::FrameReport report{.frame = frame, .cull_ms = 5.0, .drawn = true, .visible = 1000, .tested = 3000};
    early.measured(report);
    report.frame += kFirst;
    late.measured(report);
    early.drawn(frame, 0.0);
    late.drawn(frame + kFirst, 0.0);
    if (!gpu) continue;
    early.measured(engine::LateReport{frame, 1000, 0.5});
    late.measured(engine::LateReport{frame + kFirst, 1000, 0.5});
  }
  EXPECT_GT(on_gpu, 200);
}

}  // namespace
}  // namespace sightline::tests::hybrid_test
