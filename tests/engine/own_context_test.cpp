// Engines with contexts of their own, beside whatever the application has current: the system's own, OSMesa, nothing.
// GLX is in tests/apps/glx_host_test.cpp.
#include <future>
#include <memory>
#include <thread>

#include <gtest/gtest.h>

#include "sightline/engine/drawing/internal/drawing.h"
#include "sightline/engine/internal/engine_parts.h"
#include "sightline/gl/internal/dynamic_library.h"
#include "sightline/tests/engine/drawn_grid.h"
#include "sightline/tests/engine/every_call.h"
#include "sightline/tests/engine/host.h"
#include "sightline/tests/support/system_gl.h"

namespace sightline::tests::own_context_test {
namespace {

using engine::Engine;
using gl::ContextPlatform;

/// OSMesa with an image of floats, in which a clear colour shows.
class OsMesaHost final : public Host {
 public:
  static std::unique_ptr<Host> make() {
    std::unique_ptr<OsMesaHost> host(new OsMesaHost);
    return host->begin() ? std::move(host) : nullptr;
  }
  ~OsMesaHost() override {
    if (!context_) return;
    make_current_(nullptr, nullptr, 0, 0, 0);
    destroy_(context_);
  }
  std::string what_changed() const override {
    if (current_() != context_) return "another context is current";
    clear_colour_(0.25f, 0.5f, 0.75f, 1.0f);
    clear_(GL_COLOR_BUFFER_BIT);
    finish_();
    return pixels_[4 * 63] == 0.25f && pixels_[4 * 63 + 2] == 0.75f ? "" : "drawing goes elsewhere";
  }

 private:
  bool begin() {
    const auto osmesa = core::platform::open_module(kOsMesaLibrary.file);
    if (!osmesa) return false;
    void* (*create)(GLenum format, int depth, int stencil, int accumulation, void* shared) = nullptr;
    void* (*get_proc)(const char* name) = nullptr;
    gl::find_symbol(*osmesa, "OSMesaCreateContextExt", create);
    gl::find_symbol(*osmesa, "OSMesaMakeCurrent", make_current_);
    gl::find_symbol(*osmesa, "OSMesaDestroyContext", destroy_);
    gl::find_symbol(*osmesa, "OSMesaGetCurrentContext", current_);
    gl::find_symbol(*osmesa, "OSMesaGetProcAddress", get_proc);
    if (!create) return false;
    context_ = create(GL_RGBA, 24, 0, 0, nullptr);
    if (!context_ || !make_current_(context_, pixels_.data(), GL_FLOAT, 8, 8)) return false;
    clear_colour_ = reinterpret_cast<decltype(clear_colour_)>(get_proc("glClearColor"));
    clear_ = reinterpret_cast<decltype(clear_)>(get_proc("glClear"));
    finish_ = reinterpret_cast<decltype(finish_)>(get_proc("glFinish"));
    return true;
  }

  GLboolean (*make_current_)(void* context, void* pixels, GLenum type, GLsizei width, GLsizei height) = nullptr;
  void (*destroy_)(void* context) = nullptr;
  void* (*current_)() = nullptr;
  void (*clear_colour_)(float, float, float, float) = nullptr;
  void (*clear_)(GLbitfield) = nullptr;
  void (*finish_)() = nullptr;
  void* context_ = nullptr;
  std::vector<float> pixels_ = std::vector<float>(4 * 64);
};

/// An application without GL.
class NoHost final : public Host {
 public:
  static std::unique_ptr<Host> make() { return std::make_unique<NoHost>(); }
  std::string what_changed() const override {
    void* (*osmesa)() = nullptr;
    if (void* const opened = core::platform::opened_module(kOsMesaLibrary.file))
      gl::find_symbol(opened, "OSMesaGetCurrentContext", osmesa);
    return system_context_is_current() || (osmesa && osmesa()) ? "a context is current" : "";
  }
};

struct Case {
  const char* name;
  std::unique_ptr<Host> (*host)();
  ContextPlatform platform;  // of the engine
  bool osmesa = true;        // takes part
};

std::string name_of_case(const testing::TestParamInfo<Case>& info) {
  return info.param.name;
}

void fill(core::Scene& scene) {
  for (int i = 0; i < 300; ++i)
    scene.add_primitive(scene.root(), core::Cylinder{0.2f, 0.5f}, core::translation({i % 7, i / 7 % 7, i / 49}));
}
core::View view() {
  return *core::View::perspective({{-6, -7, 9}, {3, 3, 3}, {0, 0, 1}}, 0.7, 1.0, 0.1);
}
engine::EngineConfig config(ContextPlatform platform) {
  return {.draw = true, .width = 48, .height = 48, .context = {.platform = platform, .gl_debug = true}};
}

class OwnContextBeside : public testing::TestWithParam<Case> {};

TEST_P(OwnContextBeside, EveryCallLeavesTheApplicationsContextCurrent) {
  if (GetParam().osmesa && !kHasOsMesa) GTEST_SKIP() << "no OSMesa here";
  const auto exists = gl::Context::create_offscreen({.platform = GetParam().platform});
  if (!exists && may_skip(exists.error().message)) GTEST_SKIP() << exists.error().message;
  exists->release_current();
  const std::unique_ptr<Host> host = GetParam().host();
  if (!host) {
    if (gl_required()) FAIL() << "the application's context cannot be made";
    GTEST_SKIP() << "no such context here";
  }
  ASSERT_EQ(host->what_changed(), "") << "to begin with";
  core::Scene scene;
  fill(scene);
  make_every_call(scene, config(GetParam().platform), view(),
                  [&](const std::string& call) { EXPECT_EQ(host->what_changed(), "") << "after " << call; });
}

INSTANTIATE_TEST_SUITE_P(Hosts, OwnContextBeside,
                         testing::Values(Case{"SystemBesideSystem", make_system_host, kSystemPlatform, false},
                                         Case{"OsMesaBesideSystem", make_system_host, ContextPlatform::kOsMesa},
                                         Case{"SystemBesideOsMesa", OsMesaHost::make, kSystemPlatform},
                                         Case{"OsMesaBesideOsMesa", OsMesaHost::make, ContextPlatform::kOsMesa},
                                         Case{"SystemBesideNothing", NoHost::make, kSystemPlatform, false},
                                         Case{"OsMesaBesideNothing", NoHost::make, ContextPlatform::kOsMesa}),
                         name_of_case);

/// The thread that made it waits meanwhile, and has had its own context back.
TEST(OwnContext, MovesFromThreadToThread) {
  for (const ContextPlatform platform : {kSystemPlatform, ContextPlatform::kOsMesa}) {
    if (platform == ContextPlatform::kOsMesa && !kHasOsMesa) continue;
    core::Scene scene;
    fill(scene);
    std::optional<core::Expected<Engine>> engine;
    std::promise<void> made, drawn;
    core::Expected<image::Image> of_maker, of_another;
    std::thread maker([&] {
      engine.emplace(Engine::create(scene, config(platform)));
      made.set_value();
      drawn.get_future().wait();
      if (*engine && (*engine)->frame(view())) of_maker = (*engine)->read_colour();
    });
    made.get_future().wait();
    if (*engine && (*engine)->frame(view())) of_another = (*engine)->read_colour();
    drawn.set_value();
    maker.join();
    if (!*engine && may_skip(engine->error().message)) GTEST_SKIP() << engine->error().message;
    ASSERT_TRUE(*engine) << engine->error().message;
    ASSERT_TRUE(of_maker && of_another);
    EXPECT_EQ(of_maker->pixels, of_another->pixels);
    EXPECT_TRUE((*engine)->covered().value_or(false));
  }
}

TEST(OwnContext, MayBeLeftCurrent) {
  const NoHost host;
  core::Scene scene;
  fill(scene);
  for (const auto state : {engine::GlState::kRestore, engine::GlState::kLeave}) {
    engine::EngineConfig asked = config(ContextPlatform::kAutomatic);
    asked.context.gl_state = state;
    auto engine = Engine::create(scene, asked);
    if (!engine && may_skip(engine.error().message)) GTEST_SKIP() << engine.error().message;
    ASSERT_TRUE(engine && engine->frame(view()) && engine->covered().value_or(false));
    EXPECT_EQ(host.what_changed().empty(), state == engine::GlState::kRestore);
  }
  EXPECT_EQ(host.what_changed(), "") << "its end takes the context along";
}

TEST(OwnContext, ThePlanTellsWhichContextThereIs) {
  core::Scene scene;
  fill(scene);
  auto engine = Engine::create(scene, config(ContextPlatform::kAutomatic));
  if (!engine && may_skip(engine.error().message)) GTEST_SKIP() << engine.error().message;
  ASSERT_TRUE(engine) << engine.error().message;
  for (const bool anew : {false, true}) {
    if (anew) {
      ASSERT_TRUE(engine->rebuild());
    }
    int found = 0;
    for (const engine::PlanEntry& entry : engine->plan().entries) {
      if (entry.feature != "offscreen context") continue;
      ++found;
      EXPECT_TRUE(entry.used);
      EXPECT_EQ(entry.why, engine::EngineParts::drawing(*engine)->report().platform);
    }
    EXPECT_EQ(found, 1);
  }
}

}  // namespace
}  // namespace sightline::tests::own_context_test
