// An application that draws in a window by GLX, and an engine with a context of its own on the same thread. Skipped
// without Xvfb.
#include <string>

#include <GLFW/glfw3.h>
#include <dlfcn.h>

#include "sightline/gl/context.h"
#include "sightline/tests/apps/window_test.h"
#include "sightline/tests/engine/every_call.h"

namespace sightline::tests::glx_host_test {
namespace {

using gl::ContextPlatform;

/// GL of the window, by the functions that GLFW finds.
struct WindowGl {
  void (*clear_colour)(float, float, float, float) = nullptr;
  void (*clear)(unsigned) = nullptr;
  void (*read)(int, int, int, int, unsigned, unsigned, void*) = nullptr;
  unsigned (*error)() = nullptr;

  WindowGl() {
    find("glClearColor", clear_colour);
    find("glClear", clear);
    find("glReadPixels", read);
    find("glGetError", error);
  }
  template <class Function>
  static void find(const char* name, Function& function) {
    function = reinterpret_cast<Function>(glfwGetProcAddress(name));
  }
};

class GlxHost : public WindowTest {
 protected:
  void SetUp() override {
    WindowTest::SetUp();
    if (IsSkipped() || HasFatalFailure()) return;
    ASSERT_TRUE(glfwInit());
    glfwWindowHint(GLFW_CONTEXT_CREATION_API, GLFW_NATIVE_CONTEXT_API);
    window_ = glfwCreateWindow(64, 48, "host", nullptr, nullptr);
    ASSERT_TRUE(window_);
    glfwMakeContextCurrent(window_);
    void* glx = dlopen("libGLX.so.0", RTLD_NOW | RTLD_NOLOAD);
    ASSERT_TRUE(glx);
    current_ = reinterpret_cast<void* (*)()>(dlsym(glx, "glXGetCurrentContext"));
    drawable_ = reinterpret_cast<unsigned long (*)()>(dlsym(glx, "glXGetCurrentDrawable"));
    ASSERT_TRUE(current_ && drawable_ && current_());
    gl_.emplace();
  }
  void TearDown() override {
    if (window_) glfwDestroyWindow(window_);
    glfwTerminate();
    WindowTest::TearDown();
  }

  /// Clears the window and looks at it: only what is current on this thread can do that.
  void expect_window_drawable(const std::string& when) {
    const float grey = float(++turn_ % 16) / 15.0f;
    gl_->clear_colour(grey, 1.0f - grey, 0.0f, 1.0f);
    gl_->clear(0x4000);  // GL_COLOR_BUFFER_BIT
    unsigned char pixel[4] = {};
    gl_->read(32, 24, 1, 1, 0x1908, 0x1401, pixel);  // GL_RGBA, GL_UNSIGNED_BYTE
    EXPECT_EQ(pixel[0], turn_ % 16 * 17) << when;
    EXPECT_EQ(gl_->error(), 0u) << when;
  }

  std::optional<WindowGl> gl_;
  GLFWwindow* window_ = nullptr;
  void* (*current_)() = nullptr;
  unsigned long (*drawable_)() = nullptr;
  int turn_ = 0;
};

TEST_F(GlxHost, KeepsItsContextBesideEnginesOfTheirOwn) {
  core::Scene scene;
  for (int i = 0; i < 300; ++i)
    scene.add_primitive(scene.root(), core::Cylinder{0.2f, 0.5f}, core::translation({i % 7, i / 7 % 7, i / 49}));
  const auto view = *core::View::perspective({{-6, -7, 9}, {3, 3, 3}, {0, 0, 1}}, 0.7, 1.0, 0.1);
  void* const context = current_();
  const unsigned long drawable = drawable_();
  for (const ContextPlatform platform :
       {ContextPlatform::kAutomatic, ContextPlatform::kEgl, ContextPlatform::kOsMesa}) {
    SCOPED_TRACE(name_of(platform));
    engine::EngineConfig config;
    config.width = config.height = 48;
    config.context.platform = platform;
    make_every_call(scene, config, view, [&](const std::string& call) {
      EXPECT_EQ(current_(), context) << "after " << call;
      EXPECT_EQ(drawable_(), drawable) << "after " << call;
      expect_window_drawable("after " + call);
    });
  }
}

/// A GLX context beside EGL was an error once, which the engine took for a machine without EGL.
TEST_F(GlxHost, IsNoReasonToDoWithoutEgl) {
  const auto made = gl::Context::create_offscreen({.platform = ContextPlatform::kEgl});
  ASSERT_TRUE(made) << made.error().message;
  EXPECT_EQ(current_(), nullptr) << "who makes a context himself has it current";
  made->release_current();
  glfwMakeContextCurrent(nullptr);
  glfwMakeContextCurrent(window_);
  expect_window_drawable("after making it current again");
}

}  // namespace
}  // namespace sightline::tests::glx_host_test
