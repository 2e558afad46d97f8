// With GlState::kRestore an application finds its state as it was, and with both states its own image, whatever it
// left in the context. Nothing of the engine's stays there.
#include <gtest/gtest.h>

#include "sightline/gl/external_target.h"
#include "sightline/gpuprims/internal/primitives.h"
#include "sightline/tests/engine/application.h"
#include "sightline/tests/engine/drawn_grid.h"
#include "sightline/tests/engine/hostile_states.h"
#include "sightline/tests/engine/state_dump.h"
#include "sightline/tests/support/gl_objects.h"

namespace sightline::tests::kept_state_test {
namespace {

using engine::CullerChoice;
using engine::Engine;
using engine::GlState;

constexpr int kWidth = 97, kHeight = 61;

struct Mode {
  const char* name;
  CullerChoice culler;
  culling::GpuVariant variant = {};
  int samples = 1;
  engine::OcclusionChoice occlusion = engine::OcclusionChoice::kOff;
  double budget_ms = 0.0;
  bool overlays = false;
};
std::ostream& operator<<(std::ostream& to, const Mode& mode) {
  return to << mode.name;
}
constexpr Mode kModes[] = {
    {"Cpu", CullerChoice::kCpu},
    {"CpuOcclusion", CullerChoice::kCpu, {}, 1, engine::OcclusionChoice::kOn},
    {"CpuMultisampled", CullerChoice::kCpu, {}, 4},
    {"CpuBudget", CullerChoice::kCpu, {}, 1, engine::OcclusionChoice::kOn, 50.0},
    {"GpuGeometry", CullerChoice::kGpu, culling::GpuVariant::kGeometry, 1, engine::OcclusionChoice::kOn},
    {"GpuCompute", CullerChoice::kGpu, culling::GpuVariant::kCompute, 1, engine::OcclusionChoice::kOn},
    {"CpuOverlays", CullerChoice::kCpu, {}, 1, engine::OcclusionChoice::kOff, 0.0, true},
    {"GpuOverlays", CullerChoice::kGpu, culling::GpuVariant::kGeometry, 4, engine::OcclusionChoice::kOff, 0.0, true},
};

class KeptState : public DrawnGrid, public testing::WithParamInterface<Mode> {
 protected:
  void SetUp() override {
    DrawnGrid::SetUp();
    if (!context) return;
    fill(scene, 5);
    const core::MeshId mesh = scene.add_mesh(gpuprims::tessellate(core::Box{1.5f, 1.0f, 2.0f})).value();
    scene.add_mesh_instance(scene.root(), mesh, core::translation({3.3, 1.5, 7.0}));
    scene.add_primitive(scene.root(), core::Line{0.0f, 6.0f}, core::translation({2.0, 0.0, 6.0}));
  }
  engine::EngineConfig config(GlState state) {
    engine::EngineConfig c = DrawnGrid::config(GetParam().culler, kWidth, kHeight);
    c.drawing.ids = true;
    c.context.gl_state = state;
    c.drawing.samples = GetParam().samples;
    c.culling.gpu_variant = GetParam().variant;
    c.culling.occlusion = GetParam().occlusion;
    c.losses.budget_ms = GetParam().budget_ms;
    if (GetParam().overlays) c.drawing.transparency = engine::Transparency::kBlended;
    if (c.losses.budget_ms > 0.0) c.losses.contribution_mode = engine::ContributionMode::kPoints;
    return c;
  }
  core::Expected<Engine> create(const engine::EngineConfig& c) {
    return GetParam().overlays ? create_with_overlays(scene, c) : Engine::create(scene, c);
  }
  static core::View cut(double x = 13.0) {
    core::View view = *core::View::perspective({{x, -11, 12}, {3.5, 3, 4.5}, {0, 0, 1}}, 0.42, 97.0 / 61.0, 0.1, 60.0);
    view.sections = {{glm::normalize(core::dvec3(-0.3, 1.0, 0.2)), -2.6}};
    return view;
  }
  void expect_unchanged(const StateDump& before, const char* after) {
    for (const auto& [name, values] : dump_state(gl()))
      EXPECT_EQ(values, before.at(name)) << name << ", after " << after;
    for (const std::string& error : context->take_errors()) ADD_FAILURE() << error << ", after " << after;
  }

  core::Scene scene;
};

TEST_P(KeptState, IsAsBeforeAfterEveryCall) {
  const Application application(gl(), kWidth, kHeight, kDepthModes[5]);
  const ForeignObjects own(gl());
  application.set_state();
  const auto at_all_calls = [&](const char* name) {
    SCOPED_TRACE(name);
    const StateDump before = dump_state(gl());
    const auto step = [&](const char* what, auto&& call) {
      const auto done = call();
      ASSERT_TRUE(done) << what << ": " << done.error().message;
      expect_unchanged(before, what);
    };
    auto engine = create(config(GlState::kRestore));
    ASSERT_TRUE(engine) << engine.error().message;
    expect_unchanged(before, "create()");
    step("frame()", [&] { return engine->frame(cut()); });
    step("frame() again", [&] { return engine->frame(cut()); });
    step("frame() into a target", [&] { return engine->frame(cut(9), application.target()); });
    step("frame_tile()", [&] { return engine->frame_tile(cut(9), {1000, 700, 100.0, 50.0}); });
    engine->finish();
    (void)engine->take_late_report();
    expect_unchanged(before, "take_late_report()");
    step("read_colour()", [&] { return engine->read_colour(); });
    step("read_ids()", [&] { return engine->read_ids(); });
    step("read_depth()", [&] { return engine->read_depth(cut(9)); });
    step("covered()", [&] { return engine->covered(); });
    step("framebuffer()", [&] { return engine->framebuffer(); });
    scene.set_visible(core::ItemId{5}, false);
    scene.add_primitive(scene.root(), core::Sphere{1.0f}, core::translation({3.0, 3.0, 8.0}));
    step("commit()", [&] { return engine->commit(); });
    const core::ItemId some[] = {core::ItemId{3}, core::ItemId{4}, core::ItemId{9}};
    step("set_override()", [&] { return engine->set_override(some, {.alpha = 0.3f, .outline = true}); });
    step("hide()", [&] { return engine->hide(some); });
    step("isolate()", [&] { return engine->isolate({{scene.root()}}); });
    step("frame() after overrides", [&] { return engine->frame(cut()); });
    step("clear_override()", [&] { return engine->clear_override(some); });
    step("rebuild()", [&] { return engine->rebuild(); });
    step("resize()", [&] { return engine->resize(50, 40); });
    step("set_culler()", [&] {
      return engine->set_culler(GetParam().budget_ms > 0.0 ? CullerChoice::kLinear : CullerChoice::kHybrid);
    });
    engine->drop_context();
    expect_unchanged(before, "drop_context()");
    step("use_context()", [&] { return engine->use_context(*context); });
    step("frame() in it", [&] { return engine->frame(cut()); });
    { const Engine gone = std::move(*engine); }
    expect_unchanged(before, "the destructor");
  };
  at_all_calls("nothing hostile");
  const auto states = hostile_states(own);
  for (const HostileState& state : states) state.set();
  at_all_calls("everything hostile");
  for (const HostileState& state : states) state.unset();
}

TEST_P(KeptState, IsAsBeforeAfterAFrameInEachHostileState) {
  const Application application(gl(), kWidth, kHeight, kDepthModes[5]);
  const ForeignObjects own(gl());
  auto engine = create(config(GlState::kRestore));
  ASSERT_TRUE(engine) << engine.error().message;
  for (const HostileState& state : hostile_states(own)) {
    SCOPED_TRACE(state.name);
    application.set_state();
    state.set();
    const StateDump before = dump_state(gl());
    gl::ExternalTarget target = application.target(1, 2, kWidth - 3, kHeight - 4);
    target.clear_colour = target.clear_depth = true;
    ASSERT_TRUE(engine->frame(cut(), target));
    expect_unchanged(before, "frame()");
    ASSERT_TRUE(engine->read_ids());
    expect_unchanged(before, "read_ids()");
    state.unset();
  }
}

/// Two halves of an image, with and without an engine's frame between them.
TEST_P(KeptState, TheApplicationsImageIsItsOwn) {
  const ForeignObjects own(gl());
  const core::View eye = cut();
  const Application application(gl(), kWidth, kHeight), elsewhere(gl(), kWidth, kHeight);
  const auto first = [&] {
    application.clear();
    application.draw(eye, {{{0, 2, 0}, {6, 2, 0}, {6, 2, 6}, {0, 2, 6}}}, {1.0f, 0.0f, 0.0f});
  };
  // Without setting any state: the application relies on what it has set before.
  const auto second = [&] {
    gl().ProgramUniform4f(application.program.id(), 5, 0.0f, 1.0f, 0.0f, 1.0f);
    gl().DrawArrays(GL_TRIANGLES, 1, 3);
  };
  for (const GlState kept : {GlState::kRestore, GlState::kLeave}) {
    auto engine = create(config(kept));
    ASSERT_TRUE(engine) << engine.error().message;
    for (const HostileState& state : hostile_states(own)) {
      SCOPED_TRACE(testing::Message() << state.name << (kept == GlState::kRestore ? ", restored" : ", left"));
      const auto image = [&](bool between) {
        first();
        state.set();
        if (between) {
          EXPECT_TRUE(engine->frame(eye));
          EXPECT_TRUE(engine->frame(eye, elsewhere.target()));
          // What GlState::kLeave names, an application sets anew.
          if (kept == GlState::kLeave) {
            state.unset();
            gl().Disable(GL_BLEND);
            gl().Disable(GL_CULL_FACE);
            gl().Disable(GL_DEPTH_CLAMP);
            gl().Disable(GL_RASTERIZER_DISCARD);
            gl().Enable(GL_DITHER);
            gl().ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
            gl().BindTransformFeedback(GL_TRANSFORM_FEEDBACK, 0);
            application.set_state();
            state.set();
          }
        }
        second();
        state.unset();
        return std::pair(application.pixels(), application.depths());
      };
      EXPECT_TRUE(image(false) == image(true));
    }
  }
  (void)context->take_errors();  // some states let the application's own draw fail, with the engine and without
}

TEST_P(KeptState, NothingSpoilsTheImageInTheApplicationsFramebuffer) {
  const Application application(gl(), kWidth, kHeight, kDepthModes[5], 1, GL_SRGB8_ALPHA8);
  const ForeignObjects own(gl());
  for (const GlState kept : {GlState::kRestore, GlState::kLeave}) {
    auto engine = create(config(kept));
    ASSERT_TRUE(engine) << engine.error().message;
    const auto image = [&] {
      gl::ExternalTarget target = application.target(1, 2, kWidth - 3, kHeight - 4);
      target.clear_colour = target.clear_depth = kept == GlState::kRestore;
      EXPECT_TRUE(engine->frame(cut(), target));
      return std::pair(application.pixels(), application.depths());
    };
    application.clear();
    const auto clean = image();
    for (const HostileState& state : hostile_states(own)) {
      SCOPED_TRACE(state.name);
      application.clear();
      state.set();
      const auto spoilt = image();
      state.unset();
      EXPECT_TRUE(spoilt == clean);
    }
  }
}

TEST_P(KeptState, NoObjectIsLeftBehind) {
  const Application application(gl(), kWidth, kHeight, kDepthModes[0], GetParam().samples);
  for (const GlState kept : {GlState::kRestore, GlState::kLeave}) {
    const CountedObjects objects(const_cast<gl::Functions&>(gl()));
    {
      auto engine = create(config(kept));
      ASSERT_TRUE(engine) << engine.error().message;
      for (int i = 0; i < 3; ++i) {
        ASSERT_TRUE(engine->frame(cut(9.0 + i), application.target()));
        ASSERT_TRUE(engine->read_colour());
        scene.add_primitive(scene.root(), core::Sphere{1.0f}, core::translation({3.0, 3.0, 8.0 + i}));
        ASSERT_TRUE(engine->commit());
      }
      ASSERT_TRUE(engine->rebuild());
      ASSERT_TRUE(engine->frame(cut()));
      EXPECT_GT(objects.made(), 50);
      EXPECT_GT(objects.left(), 20);
    }
    EXPECT_EQ(objects.left(), 0) << objects.what_is_left();
  }
}

INSTANTIATE_TEST_SUITE_P(Modes, KeptState, testing::ValuesIn(kModes),
                         [](const testing::TestParamInfo<Mode>& mode) { return std::string(mode.param.name); });

}  // namespace
}  // namespace sightline::tests::kept_state_test
