// What the engine decides by measured times, on cards that do not exist: see SimulatedGpu. Each figure is of the
// virtual clock, so that none depends on the machine.
#include "sightline/tests/support/simulated_gpu.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "sightline/culling/gpu/internal/gpu_culler.h"
#include "sightline/gpuprims/internal/primitives.h"
#include "sightline/tests/engine/drawn_grid.h"

namespace sightline::tests::simulated_gpu_test {
namespace {

using engine::CullerChoice;
using engine::Engine;
using engine::EngineConfig;

CardModel card(const std::string& name) {
  CardModel model{.name = name};
  if (name == "integrated") model.draw = 5e-6, model.triangle = 10e-9, model.point = 30e-9, model.work_group = 30e-6;
  if (name == "remote") model.draw = 0.3e-6, model.triangle = 0.1e-9, model.notice = 5e-3, model.readback = 20e-3;
  if (name == "untimed") model.timers = false;
  return model;
}

/// What a frame costs the CPU beside calls of GL: of any frame, and for each visible item where the CPU culls.
struct CpuModel {
  double frame = 20e-6, item = 40e-9;
};

struct Flown {
  int frames = 0, on_gpu = 0;
  double seconds = 0.0, worst_frame = 0.0;
  std::uint64_t probes = 0;
  SimulatedGpu::Account spent = {};

  double waited() const { return spent.fences + spent.finishes + spent.readbacks; }
};

class SimulatedGpuTest : public DrawnGrid {
 protected:
  using View = core::View (*)(int frame);

  void SetUp() override {
    DrawnGrid::SetUp();
    fill(scene_, 22);
  }
  EngineConfig config(CullerChoice culler) {
    EngineConfig c = DrawnGrid::config(culler, 64, 48);
    c.culling.occlusion = engine::OcclusionChoice::kOff;
    return c;
  }
  static Flown fly(Engine& engine, int frames, const CpuModel& cpu, View path) {
    Flown flown{.frames = frames};
    const double begin = SimulatedGpu::now();
    const SimulatedGpu::Account before = SimulatedGpu::account();
    for (int i = 0; i < frames; ++i) {
      const double frame_begin = SimulatedGpu::now();
      const auto report = engine.frame(path(i));
      EXPECT_TRUE(report) << report.error().message;
      if (!report) return flown;
      const bool on_gpu = report->culler == CullerChoice::kGpu;
      SimulatedGpu::cpu_works(cpu.frame + (on_gpu ? 0.0 : cpu.item * double(report->visible)));
      flown.on_gpu += on_gpu;
      flown.worst_frame = std::max(flown.worst_frame, SimulatedGpu::now() - frame_begin);
    }
    engine.finish();
    flown.seconds = SimulatedGpu::now() - begin;
    flown.spent = SimulatedGpu::account() - before;
    if (engine.controller()) flown.probes = engine.controller()->probes();
    return flown;
  }
  /// Flies on a card of its own.
  Flown fly(const CardModel& model, const EngineConfig& c, int frames, const CpuModel& cpu, View path) {
    const SimulatedGpu gpu(*context, model);
    auto engine = Engine::create(scene_, c);
    EXPECT_TRUE(engine) << engine.error().message;
    return engine ? fly(*engine, frames, cpu, path) : Flown();
  }

  static core::View around(int frame) { return view(0.05 * frame); }
  /// From the middle, where a twentieth of the items is visible, and from afar, in turns of 30 frames.
  static core::View in_and_out(int frame) {
    if (frame / 30 % 2 == 0) return view(0.05 * frame);
    return *core::View::perspective({{11, 11, 11}, {22, 11 + 0.1 * (frame % 30), 11}, {0, 0, 1}}, 0.7, 1.5, 0.1);
  }

  core::Scene scene_;
};

class SimulatedCards : public SimulatedGpuTest, public testing::WithParamInterface<const char*> {
 protected:
  /// Without the occlusion test nobody reads an image.
  CardModel card(bool shows = false) const {
    CardModel model = simulated_gpu_test::card(GetParam());
    model.shows = shows;
    return model;
  }
};

/// On any card and with any CPU the hybrid takes hardly longer than the better of its paths, apart from what its probes
/// cost and the first frames, in which it knows neither. Where one path takes a fifth longer or less, it may stay on
/// that one for some frames after a probe, which costs next to nothing.
TEST_P(SimulatedCards, TheHybridTakesTheCheaperPath) {
  constexpr int kFrames = 120, kFirst = 5;
  constexpr CpuModel kCpus[] = {{20e-6, 0.0}, {20e-6, 40e-9}, {20e-6, 400e-9}};
  for (const View path : {around, in_and_out})
    for (const CpuModel& cpu : kCpus) {
      SCOPED_TRACE(testing::Message() << (path == around ? "around, " : "in and out, ") << 1e9 * cpu.item
                                      << " ns an item");
      const Flown by_cpu = fly(card(), config(CullerChoice::kCpu), kFrames, cpu, path);
      const Flown by_gpu = fly(card(), config(CullerChoice::kGpu), kFrames, cpu, path);
      const Flown hybrid = fly(card(), config(CullerChoice::kHybrid), kFrames, cpu, path);
      const double better = std::min(by_cpu.seconds, by_gpu.seconds);
      const double tried = double(hybrid.probes + kFirst) * std::max(by_cpu.worst_frame, by_gpu.worst_frame);
      EXPECT_LE(hybrid.seconds, 1.05 * better + tried)
          << by_cpu.seconds << " s by the CPU, " << by_gpu.seconds << " s by the GPU, " << hybrid.on_gpu << " of "
          << kFrames << " frames";
      const int on_better = by_gpu.seconds < by_cpu.seconds ? hybrid.on_gpu : kFrames - hybrid.on_gpu;
      if (path == around && std::max(by_cpu.seconds, by_gpu.seconds) > 1.2 * better) {
        EXPECT_GE(on_better, kFrames - kFirst - int(hybrid.probes));
      }
    }
}

/// A frame waits until the card has drawn the frame two before it, and for nothing else: never for what it reads back.
TEST_P(SimulatedCards, NoFrameWaitsForAReadBack) {
  constexpr int kFrames = 60;
  for (const CullerChoice culler : {CullerChoice::kCpu, CullerChoice::kGpu, CullerChoice::kHybrid}) {
    SCOPED_TRACE(name_of(culler));
    const Flown flown = fly(card(), config(culler), kFrames, {}, around);
    EXPECT_EQ(flown.spent.readbacks, 0.0);
    EXPECT_EQ(flown.spent.finishes, 0.0);
    const double cpu = flown.seconds - flown.waited(), gpu = flown.spent.busy, notice = kFrames * card().notice;
    EXPECT_LE(flown.seconds, 1.02 * std::max({cpu, gpu, 0.5 * (cpu + gpu + notice)}) + 2.0 * card().notice);
  }
}

/// Where nothing is drawn, the time of culling counts, and only timestamps tell that of the GPU.
TEST_P(SimulatedCards, WithoutTimersAndDrawingTheCpuCulls) {
  constexpr int kFrames = 120;
  const SimulatedGpu gpu(*context, card());
  SimulatedGpu::set_clock_step(1e-3);  // so long does the CPU take to cull
  EngineConfig c = config(CullerChoice::kHybrid);
  c.draw = false;
  auto engine = Engine::create(scene_, c);
  ASSERT_TRUE(engine) << engine.error().message;
  EXPECT_EQ(context->driver_test()[gl::DriverCheck::kTimer],
            card().timers ? gl::CheckResult::kPassed : gl::CheckResult::kFailed);
  const Flown flown = fly(*engine, kFrames, {}, around);
  if (card().timers)
    EXPECT_GE(flown.on_gpu, kFrames - 20);
  else
    EXPECT_LE(flown.on_gpu, 20);
}

/// Where drawing takes next to nothing, a budget soon draws everything, whatever reading back and waiting take; with
/// these alone beyond the budget, too.
TEST_P(SimulatedCards, ABudgetDrawsAllOfWhatIsCheap) {
  constexpr int kFrames = 24, kLearns = 10;
  for (const double budget_ms : {4.0, 16.0, 50.0})
    for (const auto occlusion : {engine::OcclusionChoice::kOff, engine::OcclusionChoice::kAutomatic}) {
      SCOPED_TRACE(testing::Message() << budget_ms << " ms, occlusion " << name_of(occlusion));
      const SimulatedGpu gpu(*context, card(occlusion != engine::OcclusionChoice::kOff));
      EngineConfig c = config(CullerChoice::kCpu);
      c.losses.budget_ms = budget_ms;
      c.culling.occlusion = occlusion;
      auto engine = Engine::create(scene_, c);
      ASSERT_TRUE(engine) << engine.error().message;
      for (int i = 0; i < kFrames; ++i) {
        const double begin = SimulatedGpu::now();
        const auto report = engine->frame(around(i));
        ASSERT_TRUE(report);
        if (i < kLearns) continue;
        EXPECT_EQ(report->pending, 0) << "frame " << i;
        EXPECT_LE(1e3 * (SimulatedGpu::now() - begin), std::max(budget_ms, 2e3 * card().notice + 0.5));
      }
    }
}

/// Where there is not time for all, frames take their budget: hardly more, and no less than two thirds of it. In 16 ms
/// there is time for all with the occlusion test: few items of the grid are seen.
TEST_F(SimulatedGpuTest, ABudgetIsKeptAndUsed) {
  constexpr int kFrames = 40, kLearns = 12;
  CardModel slow = card("discrete");
  slow.triangle = 1e-6;
  slow.readback = 0.5e-3;
  for (const double budget_ms : {8.0, 16.0})
    for (const auto occlusion : {engine::OcclusionChoice::kOff, engine::OcclusionChoice::kAutomatic}) {
      SCOPED_TRACE(testing::Message() << budget_ms << " ms, occlusion " << name_of(occlusion));
      const SimulatedGpu gpu(*context, slow);
      EngineConfig c = config(CullerChoice::kCpu);
      c.losses.budget_ms = budget_ms;
      c.culling.occlusion = occlusion;
      auto engine = Engine::create(scene_, c);
      ASSERT_TRUE(engine) << engine.error().message;
      int complete = 0;
      for (int i = 0; i < kFrames; ++i) {
        const double begin = SimulatedGpu::now();
        const auto report = engine->frame(around(i));
        ASSERT_TRUE(report);
        if (i < kLearns) continue;
        const double ms = 1e3 * (SimulatedGpu::now() - begin);
        EXPECT_LE(ms, 1.05 * budget_ms) << "frame " << i;
        complete += report->pending == 0;
        if (report->pending > 0) {
          EXPECT_GE(ms, 0.66 * budget_ms) << "frame " << i;
        }
      }
      if (occlusion == engine::OcclusionChoice::kOff) {
        EXPECT_EQ(complete, 0);
      } else if (budget_ms == 16.0) {
        EXPECT_GT(complete, 0);
      }
    }
}

/// The occlusion test reads depth back between passes. Whether it pays depends on what that takes on the card.
TEST_F(SimulatedGpuTest, OcclusionIsTestedWhereItPays) {
  constexpr int kFrames = 40, kTried = 8;
  core::Mesh mesh;
  mesh.positions = {{0, 0, 0}, {0.8f, 0, 0}, {0, 0.8f, 0}, {0, 0, 0.8f}};
  mesh.indices = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
  core::Scene scene;
  const core::MeshId id = *scene.add_mesh(std::move(mesh));
  for (int i = 0; i < 30 * 30 * 30; ++i)
    scene.add_mesh_instance(scene.root(), id, core::translation({i % 30, i / 30 % 30, i / 900}));
  const View afar = [](int frame) {
    const double turn = 0.01 * frame;
    const core::dvec3 centre(15.0), eye = centre + 50.0 * core::dvec3(std::cos(turn), std::sin(turn), 0.3);
    return *core::View::perspective({eye, centre, {0, 0, 1}}, 0.9, 1.5, 0.1);
  };
  for (const double readback : {0.1e-3, 20e-3}) {
    SCOPED_TRACE(testing::Message() << 1e3 * readback << " ms a read-back");
    CardModel model = card("discrete");
    model.readback = readback;
    const auto fly_with = [&](engine::OcclusionChoice occlusion) {
      const SimulatedGpu gpu(*context, model);
      EngineConfig c = config(CullerChoice::kCpu);
      c.culling.occlusion = occlusion;
      auto engine = Engine::create(scene, c);
      EXPECT_TRUE(engine) << engine.error().message;
      return engine ? fly(*engine, kFrames, {}, afar) : Flown();
    };
    const Flown off = fly_with(engine::OcclusionChoice::kOff), on = fly_with(engine::OcclusionChoice::kOn);
    const Flown automatic = fly_with(engine::OcclusionChoice::kAutomatic);
    EXPECT_EQ(on.seconds < off.seconds, readback < 1e-3)
        << on.seconds << " s with the test, " << off.seconds << " without";
    EXPECT_LE(automatic.seconds, 1.05 * std::min(on.seconds, off.seconds) +
                                     (readback < 1e-3 ? kTried * off.worst_frame : 1.5 * on.worst_frame));
  }
}

/// A card draws solids while the processor chooses among many meshes. The image is that of a rasteriser, which draws
/// all at once; solids and meshes that lie in one plane are there, too.
TEST_F(SimulatedGpuTest, SolidsThatAreDrawnBeforeMeshesAreChosenLeaveTheImageAsItIs) {
  const core::MeshId box = scene_.add_mesh(gpuprims::tessellate(core::Box{0.4f, 0.4f, 0.4f})).value();
  for (int i = 0; i < 300; ++i)
    scene_.add_mesh_instance(scene_.root(), box, core::translation({i % 20 + 0.2, i / 20 + 0.1 * (i % 3), 11.0}));
  const auto images = [&] {
    std::vector<std::vector<std::uint8_t>> found;
    EngineConfig c = config(CullerChoice::kCpu);
    c.culling.sample_test = false;  // a rasteriser's finds other triangles
    auto engine = Engine::create(scene_, c);
    EXPECT_TRUE(engine) << engine.error().message;
    for (int frame = 0; engine && frame < 10; ++frame) {
      EXPECT_TRUE(engine->frame(around(3 * frame)));
      found.push_back(engine->read_colour()->pixels);
    }
    return found;
  };
  const auto at_once = images();
  const SimulatedGpu gpu(*context, card("discrete"));
  EXPECT_EQ(images(), at_once);
}

INSTANTIATE_TEST_SUITE_P(All, SimulatedCards, testing::Values("discrete", "integrated", "remote", "untimed"),
                         [](const auto& param) { return std::string(param.param); });

}  // namespace
}  // namespace sightline::tests::simulated_gpu_test
