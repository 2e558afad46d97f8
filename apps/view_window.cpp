#include "sightline/apps/view_window.h"

#include <algorithm>
#include <numbers>
#include <utility>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

namespace sightline::apps {
namespace {

constexpr double kRadiansPerHeight = std::numbers::pi;  // dragging from the bottom of the window to its top
constexpr double kLongestStep = 0.25;                   // seconds: a hitch must not make the camera jump

core::Error glfw_error(const std::string& what) {
  const char* reason = nullptr;
  glfwGetError(&reason);
  return {what + ": " + (reason ? reason : "GLFW does not say why")};
}

gl::Proc get_proc(const char* name, void*) {
  return glfwGetProcAddress(name);
}

core::dvec2 cursor_of(GLFWwindow* window) {
  core::dvec2 cursor(0.0);
  glfwGetCursorPos(window, &cursor.x, &cursor.y);
  return cursor;
}

}  // namespace

Window::State::~State() {
  context.reset();
  if (window) glfwDestroyWindow(window);
  glfwTerminate();
}

core::Expected<Window> Window::open(const std::string& title, const std::array<int, 2>& size, bool vsync) {
  auto state = std::make_unique<State>();
  if (!glfwInit()) return tl::unexpected(glfw_error("no window can be opened"));
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, gl::kRequiredMajor);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, gl::kRequiredMinor);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_CONTEXT_ROBUSTNESS, GLFW_LOSE_CONTEXT_ON_RESET);  // ignored where it is not offered
  glfwWindowHint(GLFW_DEPTH_BITS, 0);                                   // pictures are drawn elsewhere and copied
  glfwWindowHint(GLFW_STENCIL_BITS, 0);
  state->window = glfwCreateWindow(size[0], size[1], title.c_str(), nullptr, nullptr);
  if (!state->window) return tl::unexpected(glfw_error("no window with OpenGL 4.5 can be opened"));
  glfwMakeContextCurrent(state->window);
  glfwSwapInterval(vsync ? 1 : 0);
  auto context = gl::Context::adopt(&get_proc, nullptr);
  if (!context) return tl::unexpected(context.error());
  state->context = std::move(*context);

  glfwSetWindowUserPointer(state->window, state.get());
  glfwSetKeyCallback(state->window, [](GLFWwindow* window, int key, int, int action, int) {
    if (action == GLFW_PRESS) static_cast<State*>(glfwGetWindowUserPointer(window))->pressed.push_back(key);
  });
  glfwSetScrollCallback(state->window, [](GLFWwindow* window, double, double notches) {
    static_cast<State*>(glfwGetWindowUserPointer(window))->wheel += notches;
  });
  state->cursor = cursor_of(state->window);
  state->time = glfwGetTime();
  return Window(std::move(state));
}

std::array<int, 2> Window::size() const {
  std::array<int, 2> size{};
  glfwGetFramebufferSize(state_->window, &size[0], &size[1]);
  return size;
}

void Window::set_title(const std::string& title) {
  glfwSetWindowTitle(state_->window, title.c_str());
}

bool Window::closing() const {
  return glfwWindowShouldClose(state_->window) != 0;
}

void Window::close() {
  glfwSetWindowShouldClose(state_->window, GLFW_TRUE);
}

WindowInput Window::poll() {
  glfwPollEvents();
  WindowInput input;
  for (; !closing() && (size()[0] == 0 || size()[1] == 0); input.waited = true) glfwWaitEvents();
  GLFWwindow* window = state_->window;
  const auto key = [&](int name) { return glfwGetKey(window, name) == GLFW_PRESS ? 1.0 : 0.0; };
  const auto button = [&](int name) { return glfwGetMouseButton(window, name) == GLFW_PRESS; };

  std::swap(input.pressed, state_->pressed);
  input.camera.wheel = std::exchange(state_->wheel, 0.0);
  const double now = glfwGetTime();
  input.camera.seconds = std::min(kLongestStep, now - std::exchange(state_->time, now));
  input.camera.move = {key(GLFW_KEY_D) - key(GLFW_KEY_A), key(GLFW_KEY_W) - key(GLFW_KEY_S),
                       key(GLFW_KEY_E) - key(GLFW_KEY_Q)};

  const core::dvec2 cursor = cursor_of(window);
  const core::dvec2 moved = cursor - std::exchange(state_->cursor, cursor);
  int width = 0, height = 0;
  glfwGetWindowSize(window, &width, &height);
  const core::dvec2 drag = kRadiansPerHeight / std::max(1, height) * core::dvec2(moved.x, -moved.y);
  const bool right_is_down = button(GLFW_MOUSE_BUTTON_RIGHT);
  const bool right_was_down = std::exchange(state_->right_was_down, right_is_down);
  input.orbit_begins = right_is_down && !right_was_down;
  if (right_is_down)
    input.camera.orbit = drag;
  else if (button(GLFW_MOUSE_BUTTON_LEFT))
    input.camera.look = drag;
  return input;
}

void Window::present(std::uint32_t framebuffer, const std::array<int, 2>& size) {
  constexpr GLuint kWindow = 0;
  const gl::Functions& gl = context().functions();
  // Mesa's software rasterisers notice a new size of the window only when its viewport is set.
  gl.BindFramebuffer(GL_FRAMEBUFFER, kWindow);
  gl.Viewport(0, 0, size[0], size[1]);
  gl.BlitNamedFramebuffer(framebuffer, kWindow, 0, 0, size[0], size[1], 0, 0, size[0], size[1], GL_COLOR_BUFFER_BIT,
                          GL_NEAREST);
  glfwSwapBuffers(state_->window);
}

}  // namespace sightline::apps
