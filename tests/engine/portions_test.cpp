// An engine that comes into its context in portions, whatever happens between them, draws what one draws that had the
// context from the start.
#include <algorithm>
#include <functional>
#include <optional>
#include <span>

#include <gtest/gtest.h>

#include "sightline/engine/internal/engine_parts.h"
#include "sightline/gpuprims/internal/primitives.h"
#include "sightline/tests/engine/drawing_modes.h"
#include "sightline/tests/engine/drawn_grid.h"
#include "sightline/tests/engine/state_dump.h"
#include "sightline/tests/support/effort.h"

namespace sightline::tests::portions_test {
namespace {

using engine::CullerChoice;
using engine::Engine;
using engine::EngineConfig;
using engine::Renderer;

constexpr int kGrid = 16;            // enough for several portions of a batch
constexpr int kMostPortions = 1000;  // then it does not end

class Portions : public DrawnGrid, public testing::WithParamInterface<DrawingMode> {
 protected:
  void SetUp() override {
    DrawnGrid::SetUp();
    if (!context) return;
    fill(scene, kGrid);
    const core::MeshId mesh = scene.add_mesh(gpuprims::tessellate(core::Box{1.5f, 1.0f, 2.0f})).value();
    for (int i = 0; i < 5; ++i)
      scene.add_mesh_instance(scene.root(), mesh, core::translation({2.3 * i, 1.5, 7.0}), material);
    scene.add_primitive(scene.root(), core::Line{0.0f, 6.0f}, core::translation({2.0, 0.0, 6.0}));
  }
  /// Orders that are made in the background would come at other times.
  EngineConfig mode(gl::Context* used) const {
    EngineConfig c;
    c.draw = c.drawing.ids = true;
    c.width = 96;
    c.height = 64;
    c.culling.rebuild_share = 0.0;
    c.drawing.looks.depth_shading = {0.5f, 0.5f};
    GetParam().set(c);
    c.context.application = used;
    c.context.later = !used;
    return c;
  }
  bool rays_first() const { return mode(nullptr).drawing.renderer == Renderer::kAutomatic; }
  /// Calls `between` before each portion with its number. Returns how many there were; 0: failed.
  int come(Engine& engine, gl::Context& into, const std::function<void(int)>& between = {}) {
    for (int portion = 1; portion < kMostPortions; ++portion) {
      if (between) between(portion);
      EXPECT_EQ(engine::EngineParts::drawing(engine), nullptr);
      const auto done = engine.use_context(into, 0.0);
      if (!done) return 0;
      if (*done) return portion;
    }
    ADD_FAILURE() << "it does not end";
    return 0;
  }
  void expect_same(Engine& a, Engine& b) {
    for (int turn = 0; turn < (long_run() ? 4 : 2); ++turn) {
      ASSERT_TRUE(draw_complete(a, view(0.5 * turn)) && draw_complete(b, view(0.5 * turn)));
      ASSERT_NO_FATAL_FAILURE(expect_same_image(a, b)) << "turn " << turn;
      ASSERT_EQ(a.read_ids()->ids, b.read_ids()->ids);
    }
    for (Engine* engine : {&a, &b})
      for (const std::string& error : engine->take_gl_errors()) ADD_FAILURE() << error;
  }

  core::Scene scene;
  int placed = 0;
  const Engine* first = nullptr;  // of those that share the scene: it edits
  core::MaterialId material = scene.add_material({"", {0.8f, 0.2f, 0.1f}});
};

INSTANTIATE_TEST_SUITE_P(Modes, Portions,
                         testing::ValuesIn(drawing_modes({
                             {"rays_first", [](EngineConfig& c) { c.drawing.renderer = Renderer::kAutomatic; }},
                             {"contribution", [](EngineConfig& c) { c.losses.min_projected_area = 3.0f; }},
                             {"blended",
                              [](EngineConfig& c) { c.drawing.transparency = engine::Transparency::kBlended; }},
                         })),
                         name_of);

TEST_P(Portions, DrawTheSame) {
  auto wanted = Engine::create(scene, mode(&*context)), engine = Engine::create(scene, mode(nullptr));
  ASSERT_TRUE(wanted && engine) << engine.error().message;
  const StateDump before = dump_state(context->functions());
  EXPECT_GT(come(*engine, *context,
                 [&](int) {
                   EXPECT_EQ(dump_state(context->functions()), before);
                   EXPECT_EQ(engine->frame(view(0.0))->drawn, rays_first());
                 }),
            9);
  EXPECT_EQ(dump_state(context->functions()), before);
  EXPECT_FALSE(engine->config().context.later);
  EXPECT_EQ(engine->config().context.application, &*context);
  EXPECT_EQ(engine->plan().culler, wanted->plan().culler);
  ASSERT_NO_FATAL_FAILURE(expect_same(*wanted, *engine));
}

/// Every edit comes before each portion in turn. Engines that share a scene follow it when they commit.
TEST_P(Portions, FollowEdits) {
  const core::MeshId present = scene.add_mesh(gpuprims::tessellate(core::Box{0.5f, 3.0f, 0.2f})).value();
  scene.add_mesh_instance(scene.root(), present, core::translation({9.0, 9.0, 9.0}));
  const std::function<void(Engine&, int)> edits[] = {
      [&](Engine& e, int n) {  // placements, removals and materials; appended slots
        if (&e == first) {
          const double o = 0.0137 * ++placed;  // no two faces may lie in one plane
          for (int i = 0; i < 20; ++i) {
            const auto item = core::ItemId((701 * n + 37 * i) % (kGrid * kGrid * kGrid));
            if (!scene.contains_item(item)) continue;
            if (i % 5 == 0)
              scene.remove_item(item);
            else
              scene.set_placement(item, core::translation({0.7 * i + o, n % 20 + o, 11.0 + o}));
          }
          scene.add_primitive(scene.root(), core::Box{1, 1, 1}, core::translation({11.0 + o, 8.3 + o, 11.0 + o}));
          scene.add_mesh_instance(scene.root(), present, core::translation({12.0 + o, n % 20 + o, 3.0 + o}));
          scene.update_material(material, {"", {0.1f, 0.1f * float(n % 10), 0.9f}});
        }
        ASSERT_TRUE(e.commit());
      },
      [&](Engine& e, int n) {  // overrides
        std::vector<core::ItemId> some, others;
        for (core::ItemId item = core::ItemId(n); to_index(item) < 9000; item = core::ItemId{to_index(item) + 97})
          if (scene.contains_item(item)) (to_index(item) % 2 ? some : others).push_back(item);
        ASSERT_TRUE(e.set_override(some, {.colour = core::vec3(0.2f, 0.9f, 0.1f * float(n % 10))}));
        ASSERT_TRUE(n % 2 == 0 ? e.hide(others) : e.show(others));
        ASSERT_TRUE(e.set_override({&some[2], 1}, {.alpha = 0.5f, .ghost = n % 3 == 0}));
      },
      [&](Engine& e, int n) {  // what was not there, once
        if (n != 4) return;
        if (&e == first) {
          scene.add_primitive(scene.root(), core::Sphere{4.0f},
                              core::translation({6.0, 8.0, 11.0 + 0.0171 * ++placed}));
          const core::MeshId fresh = scene.add_mesh(gpuprims::tessellate(core::Box{3.0f, 3.0f, 0.2f})).value();
          scene.add_mesh_instance(scene.root(), fresh, core::translation({17.0, 12.0, 9.0 + 0.0171 * placed}));
        }
        ASSERT_TRUE(e.commit());
      },
      [&](Engine& e, int n) {  // another order, other sizes and settings
        if (n == 3) {
          ASSERT_TRUE(e.rebuild());
        }
        if (n % 2 == 1) {
          ASSERT_TRUE(e.resize(64 + n, 64) && e.resize(96, 64));
        }
        EngineConfig c = e.config();
        c.drawing.looks.depth_shading.edge_lines = n % 2 == 0 ? 0.5f : 0.0f;
        c.drawing.looks.hatching.strength = n % 2 == 0 ? 0.5f : 0.0f;
        ASSERT_TRUE(e.configure(c));
      },
  };
  constexpr int kPlaces[] = {-1, 3, 1, 8};  // -1: before each
  for (const auto& edit : edits)
    for (const int at : std::span(kPlaces).first(long_run() ? 4 : 2)) {
      SCOPED_TRACE(testing::Message() << "edit " << &edit - edits << " before " << at);
      auto wanted = Engine::create(scene, mode(&*context)), engine = Engine::create(scene, mode(nullptr));
      ASSERT_TRUE(wanted && engine);
      first = &*wanted;
      ASSERT_GT(come(*engine, *context,
                     [&](int portion) {
                       if (at >= 0 && at != portion) return;
                       if (portion > 40) return;
                       for (Engine* e : {&*wanted, &*engine}) edit(*e, at >= 0 ? 4 : portion);
                     }),
                0);
      ASSERT_NO_FATAL_FAILURE(expect_same(*wanted, *engine));
    }
}

/// The next call begins anew, in another context.
TEST_P(Portions, SurviveALoss) {
  for (const int at : {1, 3, 8}) {
    SCOPED_TRACE(at);
    auto made = gl::Context::create_offscreen();
    ASSERT_TRUE(made);
    auto wanted = Engine::create(scene, mode(&*context)), engine = Engine::create(scene, mode(nullptr));
    ASSERT_TRUE(wanted && engine);
    EXPECT_EQ(come(*engine, *made,
                   [&](int portion) {
                     if (portion == at) lose(*made);
                   }),
              0);
    EXPECT_EQ(engine->frame(view(0.0))->drawn, rays_first());
    ASSERT_TRUE(engine->hide(std::vector<core::ItemId>{core::ItemId{5}}) && engine->show_all());
    made = gl::Context::create_offscreen();
    ASSERT_TRUE(made && context->make_current());
    ASSERT_GT(come(*engine, *context), 0);
    ASSERT_NO_FATAL_FAILURE(expect_same(*wanted, *engine));
  }
}

int calls_left = 0;
decltype(gl::Functions::GetError) real_error = nullptr;

GLenum error_after_some_calls() {
  const GLenum error = real_error();
  return error != GL_NO_ERROR || --calls_left > 0 ? error : GLenum(GL_OUT_OF_MEMORY);
}

/// Memory runs out at any allocation: the call fails, nothing has changed, and the next one begins anew.
TEST_P(Portions, SurviveTooLittleMemory) {
  auto wanted = Engine::create(scene, mode(&*context)), engine = Engine::create(scene, mode(nullptr));
  ASSERT_TRUE(wanted && engine);
  auto& gl = const_cast<gl::Functions&>(context->functions());
  real_error = gl.GetError;
  int failures = 0;
  for (int calls = 1; calls < 200; calls += 1 + calls / 2) {
    calls_left = calls;
    gl.GetError = error_after_some_calls;
    const bool came = come(*engine, *context) > 0;
    gl.GetError = real_error;
    if (came) break;
    ++failures;
    EXPECT_TRUE(engine->config().context.later);
    EXPECT_EQ(engine->frame(view(0.0))->drawn, rays_first());
  }
  EXPECT_GT(failures, 3);
  if (!engine::EngineParts::drawing(*engine)) {
    ASSERT_GT(come(*engine, *context), 0);
  }
  ASSERT_NO_FATAL_FAILURE(expect_same(*wanted, *engine));
}

/// Whoever gives up in the middle leaves nothing behind: the engine ends, or gets all at once, or in another context.
TEST_P(Portions, MayBeGivenUp) {
  auto other = gl::Context::create_offscreen();
  ASSERT_TRUE(other);
  for (const int at : {1, 4, 7}) {
    SCOPED_TRACE(at);
    auto gone = Engine::create(scene, mode(nullptr)), engine = Engine::create(scene, mode(nullptr));
    auto wanted = Engine::create(scene, mode(&*context));
    ASSERT_TRUE(gone && engine && wanted && other->make_current());
    for (int portion = 0; portion < at; ++portion) {
      ASSERT_FALSE(*gone->use_context(*other, 0.0));
      ASSERT_FALSE(*engine->use_context(*other, 0.0));
    }
    { const Engine end = std::move(*gone); }
    ASSERT_TRUE(context->make_current());
    if (at % 2 == 0) {
      ASSERT_TRUE(engine->use_context(*context));
    } else {
      ASSERT_GT(come(*engine, *context), 0);
    }
    ASSERT_NO_FATAL_FAILURE(expect_same(*wanted, *engine));
  }
}

}  // namespace
}  // namespace sightline::tests::portions_test
