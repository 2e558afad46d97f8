// Frames of a flight that was flown before allocate nothing.
#include <cmath>

#include <gtest/gtest.h>

#include "sightline/core/scene.h"
#include "sightline/gpuprims/internal/primitives.h"
#include "sightline/tests/engine/drawing_modes.h"
#include "sightline/tests/support/counted_memory.h"

namespace sightline::tests::steady_frames_test {
namespace {

using engine::Engine;
using engine::EngineConfig;

constexpr int kViews = 12;

class SteadyFrames : public DrawnGrid, public testing::WithParamInterface<DrawingMode> {
 protected:
  void SetUp() override {
    DrawnGrid::SetUp();
    fill(scene, 22);
    const core::MeshId ball = scene.add_mesh(gpuprims::tessellate(core::Sphere{2.0f}, {.fixed_segments = 60})).value();
    for (int i = 0; i < 40; ++i)
      scene.add_mesh_instance(scene.root(), ball, core::translation({i % 5 * 5.0, i / 5 * 3.0, 23.0}));
    for (int i = 0; i < 20; ++i)
      scene.add_primitive(scene.root(), core::Line{-9, 9}, core::translation({0.4 * i, 4, 0.35 * i}));
  }
  /// Flies around once; returns what that has allocated.
  static std::size_t fly(Engine& engine) {
    const std::size_t before = allocations;
    for (int i = 0; i < kViews; ++i) EXPECT_TRUE(engine.frame(view(0.5 * i)));
    engine.finish();
    return allocations - before;
  }
  core::Scene scene;
};

INSTANTIATE_TEST_SUITE_P(
    , SteadyFrames,
    testing::Values(DrawingMode{"plain", [](EngineConfig&) {}},
                    DrawingMode{"several_threads", [](EngineConfig& c) { c.threads = 3; }},
                    DrawingMode{"looks", [](EngineConfig& c) { c.drawing.looks = engine::Looks::standard(); }},
                    DrawingMode{"samples", [](EngineConfig& c) { c.drawing.samples = 4; }},
                    DrawingMode{"levels", [](EngineConfig& c) { c.losses.lod_error = 1.0; }},
                    DrawingMode{"occlusion",
                                [](EngineConfig& c) { c.culling.occlusion = engine::OcclusionChoice::kOn; }}),
    name_of);

TEST_P(SteadyFrames, AllocateNothing) {
  EngineConfig c = config(engine::CullerChoice::kCpu);
  c.context.gl_state = engine::GlState::kLeave;  // what is given back after a call is kept in one allocation
  GetParam().set(c);
  auto engine = Engine::create(scene, c);
  ASSERT_TRUE(engine) << engine.error().message;
  ASSERT_TRUE(engine->finish_levels());
  std::size_t found = fly(*engine);
  // Buffers grow with what they hold, and the driver compiles.
  for (int i = 0; i < 60 && found > 0; ++i) found = fly(*engine);
  EXPECT_EQ(found, 0u) << "in " << kViews << " frames";
}

}  // namespace
}  // namespace sightline::tests::steady_frames_test
