#include "sightline/apps/view/window.h"

#include <algorithm>
#include <span>
#include <utility>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "sightline/gl/functions.h"
#include "sightline/gl/internal/framebuffer.h"
#include "sightline/gl/internal/texture.h"

namespace sightline::apps {
namespace {

constexpr GLuint kBackBuffer = 0;

core::Error glfw_error(const std::string& what) {
  const char* reason = nullptr;
  glfwGetError(&reason);
  return {what + ": " + (reason ? reason : "GLFW does not say why")};
}

gl::Proc get_proc(const char* name, void*) {
  return glfwGetProcAddress(name);
}

void ask_for(int major, int minor) {
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, major);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, minor);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
}

/// What there is of OpenGL, for somebody who asks why it is not enough.
std::string offered() {
  for (const bool core : {true, false}) {
    glfwDefaultWindowHints();
    glfwWindowHint(GLFW_VISIBLE, GLFW_FALSE);
    if (core) ask_for(3, 2);  // drivers give the newest that goes with it
    GLFWwindow* window = glfwCreateWindow(16, 16, "", nullptr, nullptr);
    if (!window) continue;
    glfwMakeContextCurrent(window);
    const auto get = reinterpret_cast<const GLubyte* (*)(GLenum)>(glfwGetProcAddress("glGetString"));
    const auto text = [&](GLenum name) {
      const GLubyte* found = get ? get(name) : nullptr;
      return found ? std::string(reinterpret_cast<const char*>(found)) : std::string("an unknown one");
    };
    const std::string words = text(GL_VERSION) + " by " + text(GL_RENDERER);
    glfwDestroyWindow(window);
    return words;
  }
  return "none";
}

/// Pixels per screen unit.
core::dvec2 pixels_of(GLFWwindow* window, double x, double y) {
  int width = 0, height = 0, pixels_wide = 0, pixels_high = 0;
  glfwGetWindowSize(window, &width, &height);
  glfwGetFramebufferSize(window, &pixels_wide, &pixels_high);
  return {x * pixels_wide / std::max(1, width), y * pixels_high / std::max(1, height)};
}

core::dvec2 cursor_of(GLFWwindow* window) {
  double x = 0.0, y = 0.0;
  glfwGetCursorPos(window, &x, &y);
  return pixels_of(window, x, y);
}

std::string utf8(unsigned code) {
  std::string text;
  const auto tail = [&](int shift) { text += char(0x80 | (code >> shift & 0x3f)); };
  if (code < 0x80) {
    text += char(code);
  } else if (code < 0x800) {
    text += char(0xc0 | code >> 6);
    tail(0);
  } else if (code < 0x10000) {
    text += char(0xe0 | code >> 12);
    tail(6), tail(0);
  } else {
    text += char(0xf0 | code >> 18);
    tail(12), tail(6), tail(0);
  }
  return text;
}

std::vector<Event>& events_of(GLFWwindow* window) {
  return *static_cast<std::vector<Event>*>(glfwGetWindowUserPointer(window));
}

void listen(GLFWwindow* window, std::vector<Event>& events) {
  glfwSetWindowUserPointer(window, &events);
  glfwSetKeyCallback(window, [](GLFWwindow* w, int key, int, int action, int mods) {
    events_of(w).push_back({.type = Event::Type::kKey, .key = key, .mods = mods, .down = action != GLFW_RELEASE});
  });
  glfwSetCharCallback(window, [](GLFWwindow* w, unsigned code) {
    events_of(w).push_back({.type = Event::Type::kText, .text = utf8(code)});
  });
  glfwSetMouseButtonCallback(window, [](GLFWwindow* w, int button, int action, int mods) {
    events_of(w).push_back(
        {.type = Event::Type::kButton, .key = button, .mods = mods, .down = action == GLFW_PRESS, .at = cursor_of(w)});
  });
  glfwSetCursorPosCallback(window, [](GLFWwindow* w, double x, double y) {
    events_of(w).push_back({.type = Event::Type::kCursor, .at = pixels_of(w, x, y)});
  });
  glfwSetScrollCallback(window, [](GLFWwindow* w, double, double notches) {
    events_of(w).push_back({.type = Event::Type::kWheel, .at = cursor_of(w), .wheel = notches});
  });
  glfwSetWindowRefreshCallback(window, [](GLFWwindow* w) { events_of(w).push_back({.type = Event::Type::kExpose}); });
  glfwSetFramebufferSizeCallback(
      window, [](GLFWwindow* w, int, int) { events_of(w).push_back({.type = Event::Type::kExpose}); });
  glfwSetDropCallback(window, [](GLFWwindow* w, int count, const char** paths) {
    events_of(w).push_back({.type = Event::Type::kDrop, .files = {paths, paths + count}});
  });
}

/// GL has the lowest row first.
void flip_rows(image::Image& image) {
  const auto row = 3 * std::ptrdiff_t(image.width);
  for (int y = 0; y < image.height / 2; ++y)
    std::swap_ranges(image.pixels.begin() + y * row, image.pixels.begin() + (y + 1) * row,
                     image.pixels.begin() + (image.height - 1 - y) * row);
}

}  // namespace

Window::State::~State() {
  kept = {};
  context.reset();
  if (window) glfwDestroyWindow(window);
  glfwTerminate();
}

core::Expected<Window> Window::open(const std::string& title, const std::array<int, 2>& size, bool vsync) {
  auto state = std::make_unique<State>();
  if (!glfwInit()) {
    core::Error error = glfw_error("no window can be opened");
    error.message += "; sightline-render draws without one";
    return tl::unexpected(std::move(error));
  }
  state->title = title;
  state->vsync = vsync;
  if (auto done = state->open(size); !done) return tl::unexpected(done.error());
  return Window(std::move(state));
}

/// Makes a window in place of the one that there is, if any.
core::Expected<void> Window::State::open(const std::array<int, 2>& size) {
  glfwDefaultWindowHints();
  ask_for(gl::kRequiredMajor, gl::kRequiredMinor);
  glfwWindowHint(GLFW_CONTEXT_ROBUSTNESS, GLFW_LOSE_CONTEXT_ON_RESET);  // ignored where it is not offered
  glfwWindowHint(GLFW_DEPTH_BITS, 0);                                   // images are drawn elsewhere and copied
  glfwWindowHint(GLFW_STENCIL_BITS, 0);
  if (window) glfwWindowHint(GLFW_VISIBLE, GLFW_FALSE);  // until it is where the former one is
  GLFWwindow* made = glfwCreateWindow(size[0], size[1], title.c_str(), nullptr, nullptr);
  if (!made) {
    core::Error error = glfw_error("no window can be opened that has OpenGL " + std::to_string(gl::kRequiredMajor) +
                                   "." + std::to_string(gl::kRequiredMinor) + " core");
    error.message += "; the display offers " + offered() +
                     "; LIBGL_ALWAYS_SOFTWARE=1 takes Mesa's software rasteriser, which has 4.5";
    return tl::unexpected(std::move(error));
  }
  glfwMakeContextCurrent(made);
  glfwSwapInterval(vsync ? 1 : 0);
  auto adopted = gl::Context::adopt(&get_proc, nullptr);
  if (!adopted) {
    glfwDestroyWindow(made);
    if (window) glfwMakeContextCurrent(window);
    return tl::unexpected(adopted.error());
  }
  context.reset();  // whoever shares it takes it as lost
  context = std::move(*adopted);
  if (window) {
    int x = 0, y = 0;
    glfwGetWindowPos(window, &x, &y);
    glfwSetWindowPos(made, x, y);
    if (glfwGetWindowAttrib(window, GLFW_MAXIMIZED)) glfwMaximizeWindow(made);
    if (glfwWindowShouldClose(window)) glfwSetWindowShouldClose(made, GLFW_TRUE);
    glfwDestroyWindow(window);
    glfwShowWindow(made);
  }
  window = made;
  events.clear();
  listen(window, events);
  return {};
}

core::Expected<void> Window::reopen() {
  state_->kept = {};
  return state_->open(screen_size());
}

std::array<int, 2> Window::size() const {
  std::array<int, 2> size{};
  glfwGetFramebufferSize(state_->window, &size[0], &size[1]);
  return size;
}

std::array<int, 2> Window::screen_size() const {
  std::array<int, 2> size{};
  glfwGetWindowSize(state_->window, &size[0], &size[1]);
  return size;
}

void Window::resize(const std::array<int, 2>& size) {
  glfwSetWindowSize(state_->window, size[0], size[1]);
}

double Window::scale() const {
  float x = 1.0f, y = 1.0f;
  glfwGetWindowContentScale(state_->window, &x, &y);
  return std::max({1.0f, x, y});
}

void Window::set_title(const std::string& title) {
  state_->title = title;
  glfwSetWindowTitle(state_->window, title.c_str());
}

std::string Window::clipboard() const {
  const char* text = glfwGetClipboardString(state_->window);
  return text ? text : "";
}

void Window::set_clipboard(const std::string& text) {
  glfwSetClipboardString(state_->window, text.c_str());
}

bool Window::closing() const {
  return glfwWindowShouldClose(state_->window) != 0;
}

void Window::close() {
  glfwSetWindowShouldClose(state_->window, GLFW_TRUE);
}

void Window::keep_open() {
  glfwSetWindowShouldClose(state_->window, GLFW_FALSE);
  if (glfwGetWindowAttrib(state_->window, GLFW_ICONIFIED) != 0) glfwRestoreWindow(state_->window);
}

std::vector<Event> Window::poll(double wait) {
  if (wait > 0.0)
    glfwWaitEventsTimeout(wait);
  else
    glfwPollEvents();
  while (!closing() && (size()[0] == 0 || size()[1] == 0)) glfwWaitEvents();
  return std::exchange(state_->events, {});
}

void Window::wake() {
  glfwPostEmptyEvent();
}

void Window::copy(std::uint32_t framebuffer, const std::array<int, 2>& size, const Part& to, int begin, int end) {
  const gl::Functions& gl = context().functions();
  const bool same = size == std::array{to.width, to.height};
  const auto column = [&](int of_image) { return to.x + of_image * to.width / size[0]; };
  gl.BlitNamedFramebuffer(framebuffer, kBackBuffer, begin, 0, end, size[1], column(begin), to.y, column(end),
                          to.y + to.height, GL_COLOR_BUFFER_BIT, same ? GL_NEAREST : GL_LINEAR);
}

core::Expected<void> Window::keep(const image::Image* image) {
  state_->kept = {};
  if (!image) return {};
  const gl::Functions& gl = context().functions();
  auto texture = gl::Texture2D::create(gl, image->width, image->height, GL_RGB8, "image at rest");
  if (!texture) return tl::unexpected(texture.error());
  const gl::Attachment attachment{GL_COLOR_ATTACHMENT0, &*texture};
  auto framebuffer = gl::Framebuffer::create(gl, {&attachment, 1}, "image at rest");
  if (!framebuffer) return tl::unexpected(framebuffer.error());
  image::Image rows = *image;
  flip_rows(rows);
  gl.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  texture->write(GL_RGB, GL_UNSIGNED_BYTE, std::as_bytes(std::span(rows.pixels)));
  state_->kept = {std::move(*texture), std::move(*framebuffer)};
  return {};
}

void Window::copy_kept(const Part& to) {
  const gl::Texture2D& texture = state_->kept.texture;
  copy(state_->kept.framebuffer.id(), {texture.width(), texture.height()}, to);
}

void Window::clear(const core::vec3& colour) {
  const gl::Functions& gl = context().functions();
  const std::array<int, 2> all = size();
  // Mesa's software rasterisers notice a new size of the window only when its viewport is set.
  gl.BindFramebuffer(GL_FRAMEBUFFER, kBackBuffer);
  gl.Viewport(0, 0, all[0], all[1]);
  gl.Disable(GL_SCISSOR_TEST);
  const std::array<float, 4> rgba{colour.r, colour.g, colour.b, 1.0f};
  gl.ClearNamedFramebufferfv(kBackBuffer, GL_COLOR, 0, rgba.data());
}

image::Image Window::read() const {
  const gl::Functions& gl = context().functions();
  const std::array<int, 2> all = size();
  image::Image image{all[0], all[1], std::vector<std::uint8_t>(3 * std::size_t(all[0]) * std::size_t(all[1]))};
  gl.BindFramebuffer(GL_READ_FRAMEBUFFER, kBackBuffer);
  gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
  gl.ReadPixels(0, 0, all[0], all[1], GL_RGB, GL_UNSIGNED_BYTE, image.pixels.data());
  flip_rows(image);
  return image;
}

void Window::present() {
  glfwSwapBuffers(state_->window);
}

}  // namespace sightline::apps
