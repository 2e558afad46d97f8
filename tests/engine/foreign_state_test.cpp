// Whatever an application leaves in the context that it shares with an engine, images, ids, depths and counts are
// those of a clean context, bit for bit.
#include <gtest/gtest.h>

#include "sightline/engine/internal/engine_parts.h"
#include "sightline/gpuprims/internal/primitives.h"
#include "sightline/tests/engine/drawn_grid.h"
#include "sightline/tests/engine/hostile_states.h"
#include "sightline/tests/support/effort.h"

namespace sightline::tests::foreign_state_test {
namespace {

using engine::CullerChoice;
using engine::Engine;

struct Mode {
  const char* name;
  CullerChoice culler;
  culling::GpuVariant variant;
  int samples;
  engine::OcclusionChoice occlusion = engine::OcclusionChoice::kAutomatic;
  bool overlays = false;
};

std::ostream& operator<<(std::ostream& to, const Mode& mode) {
  return to << mode.name;
}

class ForeignState : public DrawnGrid, public testing::WithParamInterface<Mode> {
 protected:
  void SetUp() override {
    DrawnGrid::SetUp();
    if (!context) return;
    fill(scene, 7);
    const core::Material half{"half", {0.9f, 0.2f, 0.1f}, 0.5f};
    const core::MaterialId material = scene.add_material(half);
    const core::MeshId mesh = scene.add_mesh(gpuprims::tessellate(core::Box{1.5f, 1.0f, 2.0f})).value();
    for (int i = 0; i < 3; ++i) {
      scene.add_mesh_instance(scene.root(), mesh, core::translation({2.0 * i + 0.3, 1.5, 7.0}));
      scene.add_primitive(scene.root(), core::Sphere{1.8f}, core::translation({2.0 * i, 4.5, 7.0}), material);
      scene.add_primitive(scene.root(), core::Line{0.0f, 6.0f}, core::translation({2.0 * i, 0.0, 6.0}));
    }
  }

  engine::EngineConfig config() {
    engine::EngineConfig c = DrawnGrid::config(GetParam().culler, 97, 61);
    c.drawing.ids = true;
    c.drawing.samples = GetParam().samples;
    c.culling.gpu_variant = GetParam().variant;
    c.culling.occlusion = GetParam().occlusion;
    if (GetParam().overlays) c.drawing.transparency = engine::Transparency::kBlended;
    return c;
  }
  core::Expected<Engine> create(const engine::EngineConfig& c) {
    return GetParam().overlays ? create_with_overlays(scene, c) : Engine::create(scene, c);
  }
  /// Part of the scene, cut open.
  static core::View cut() {
    core::View view = *core::View::perspective({{13, -11, 12}, {3.5, 3, 4.5}, {0, 0, 1}}, 0.42, 97.0 / 61.0, 0.1);
    view.sections = {{glm::normalize(core::dvec3(-0.3, 1.0, 0.2)), -2.6}};
    return view;
  }

  struct Shown {
    image::Image colour;
    image::IdImage ids;
    image::DepthImage depth;
    std::int64_t visible = 0;
  };
  static Shown read(Engine& engine) {
    const render::RenderTarget& target = engine::EngineParts::drawing(engine)->target();
    return {target.read_colour(), target.read_ids(), target.read_depth(cut()), 0};
  }
  /// Submits and waits; how many items are visible, which a GPU tells late.
  static std::int64_t frame(Engine& engine, const core::View& view = cut()) {
    const auto report = engine.frame(view);
    EXPECT_TRUE(report) << report.error().message;
    engine.finish();
    const auto late = engine.take_late_report();
    return late ? late->visible : report->visible;
  }
  /// So that nothing is right only because it was there before.
  static void draw_another(Engine& engine) {
    frame(engine, *core::View::perspective({{-9, -4, 2}, {3.5, 3, 3}, {0, 0, 1}}, 0.9, 97.0 / 61.0, 0.1));
  }
  /// In a context that nobody else has touched.
  Shown wanted() {
    auto clean = gl::Context::create_offscreen();
    EXPECT_TRUE(clean);
    engine::EngineConfig c = config();
    c.context.application = &*clean;
    auto engine = create(c);
    EXPECT_TRUE(engine) << engine.error().message;
    const std::int64_t visible = frame(*engine);
    Shown shown = read(*engine);
    shown.visible = visible;
    engine = tl::unexpected(core::Error{});  // before its context
    EXPECT_TRUE(context->make_current());
    return shown;
  }
  void expect_same(const Shown& shown, const Shown& same) {
    EXPECT_TRUE(shown.colour.pixels == same.colour.pixels) << "another image";
    EXPECT_TRUE(shown.ids.ids == same.ids.ids) << "other ids";
    EXPECT_TRUE(shown.depth.metres == same.depth.metres) << "other depths";
    EXPECT_EQ(shown.visible, same.visible);
    for (const std::string& error : context->take_errors()) ADD_FAILURE() << error;
  }

  core::Scene scene;
};

TEST_P(ForeignState, SpoilsNoFrameAndNoReadBack) {
  const Shown clean = wanted();
  ASSERT_GT(std::count(clean.ids.ids.begin(), clean.ids.ids.end(), 0u), 500);
  ASSERT_GT(std::count_if(clean.ids.ids.begin(), clean.ids.ids.end(), [](std::uint32_t id) { return id != 0; }),
            GetParam().overlays ? 1000 : 1500);
  ASSERT_GT(std::count_if(clean.ids.ids.begin(), clean.ids.ids.end(), [](std::uint32_t id) { return id > 343; }),
            GetParam().overlays ? 150 : 300);
  const ForeignObjects own(gl());
  auto engine = create(config());
  ASSERT_TRUE(engine) << engine.error().message;
  for (const HostileState& state : hostile_states(own)) {
    if (!long_run()) {
      SCOPED_TRACE(state.name);
      draw_another(*engine);
      state.set();
      const std::int64_t visible = frame(*engine);
      Shown shown = read(*engine);
      state.unset();
      shown.visible = visible;
      expect_same(shown, clean);
      continue;
    }
    {
      SCOPED_TRACE(testing::Message() << state.name << ", in frames");
      draw_another(*engine);
      state.set();
      const std::int64_t visible = frame(*engine);
      state.unset();
      Shown shown = read(*engine);
      shown.visible = visible;
      expect_same(shown, clean);
    }
    {
      SCOPED_TRACE(testing::Message() << state.name << ", in read-backs");
      draw_another(*engine);
      const std::int64_t visible = frame(*engine);
      state.set();
      Shown shown = read(*engine);
      state.unset();
      shown.visible = visible;
      expect_same(shown, clean);
    }
  }
}

TEST_P(ForeignState, MayBeAllThereIsFromTheFirstCallOn) {
  const Shown clean = wanted();
  const ForeignObjects own(gl());
  for (const HostileState& state : hostile_states(own)) state.set();
  auto engine = create(config());
  ASSERT_TRUE(engine) << engine.error().message;
  draw_another(*engine);
  const std::int64_t visible = frame(*engine);
  Shown shown = read(*engine);
  shown.visible = visible;
  for (const HostileState& state : hostile_states(own)) state.unset();
  expect_same(shown, clean);
}

INSTANTIATE_TEST_SUITE_P(
    Modes, ForeignState,
    testing::Values(
        Mode{"Cpu", CullerChoice::kCpu, {}, 1}, Mode{"CpuMultisampled", CullerChoice::kCpu, {}, 4},
        Mode{"GpuGeometry", CullerChoice::kGpu, culling::GpuVariant::kGeometry, 1},
        Mode{"GpuCompute", CullerChoice::kGpu, culling::GpuVariant::kCompute, 1},
        Mode{"GpuComputeMultisampled", CullerChoice::kGpu, culling::GpuVariant::kCompute, 4},
        Mode{"GpuGeometryOcclusion", CullerChoice::kGpu, culling::GpuVariant::kGeometry, 1,
             engine::OcclusionChoice::kOn},
        Mode{"GpuComputeOcclusion", CullerChoice::kGpu, culling::GpuVariant::kCompute, 1, engine::OcclusionChoice::kOn},
        Mode{"CpuOverlays", CullerChoice::kCpu, {}, 4, engine::OcclusionChoice::kAutomatic, true},
        Mode{"GpuOverlays", CullerChoice::kGpu, culling::GpuVariant::kGeometry, 1, engine::OcclusionChoice::kOn, true}),
    [](const testing::TestParamInfo<Mode>& mode) { return std::string(mode.param.name); });

}  // namespace
}  // namespace sightline::tests::foreign_state_test
