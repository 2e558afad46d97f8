// The window of sightline-view: GLFW, an OpenGL context, and user input in the camera's terms.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sightline/apps/common/camera_control.h"
#include "sightline/gl/context.h"
#include "sightline/gl/internal/framebuffer.h"

struct GLFWwindow;

namespace sightline::apps {

/// What the user has done since the last poll().
struct WindowInput {
  CameraInput camera;
  std::vector<int> pressed;   ///< GLFW's key numbers, in order
  bool orbit_begins = false;  ///< the right button went down
  bool waited = false;        ///< the window was minimised
};

class Window {
 public:
  /// Opens a window with an OpenGL 4.5 core context and makes it current on this thread. The context is robust where
  /// the platform offers that. `size`: in screen units. With `vsync`, present() waits for the screen. Without a display
  /// or such a context it fails with GLFW's reason. Only one window may be open at a time.
  static core::Expected<Window> open(const std::string& title, const std::array<int, 2>& size, bool vsync);

  const gl::Context& context() const { return state_->context.value(); }
  gl::Context& context() { return state_->context.value(); }
  /// Size of its framebuffer, in pixels; 0 while minimised.
  std::array<int, 2> size() const;
  void set_title(const std::string& title);

  bool closing() const;
  void close();
  /// Never waits, except while the window is minimised.
  WindowInput poll();
  /// Shows a framebuffer object of the given size.
  void present(std::uint32_t framebuffer, const std::array<int, 2>& size);

 private:
  struct State {
    State() = default;
    State(const State&) = delete;
    State& operator=(const State&) = delete;
    ~State();

    GLFWwindow* window = nullptr;
    std::optional<gl::Context> context;
    std::vector<int> pressed;
    double wheel = 0.0, time = 0.0;
    core::dvec2 cursor{0.0};
    bool right_was_down = false;
  };
  explicit Window(std::unique_ptr<State> state) : state_(std::move(state)) {}

  std::unique_ptr<State> state_;  // at a fixed address: GLFW's callbacks point to it
};

}  // namespace sightline::apps
