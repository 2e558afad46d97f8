// The window of sightline-view: GLFW, an OpenGL context, and what the user does, in the camera's terms.
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
  /// Opens a window of so many screen units with an OpenGL 4.5 core context, robust where the platform offers that,
  /// which is current on this thread from then on. With `vsync`, present() waits for the screen. Fails without a
  /// display or such a context, with GLFW's reason. One at a time.
  static core::Expected<Window> open(const std::string& title, const std::array<int, 2>& size, bool vsync);

  const gl::Context& context() const { return state_->context.value(); }
  gl::Context& context() { return state_->context.value(); }
  /// Of its framebuffer, in pixels; 0 while minimised.
  std::array<int, 2> size() const;
  void set_title(const std::string& title);

  bool closing() const;
  void close();
  /// Never waits, but for the window to come back while it is minimised.
  WindowInput poll();
  /// Shows a framebuffer object of the size given.
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

  std::unique_ptr<State> state_;  // at a fixed address: GLFW's callbacks know it
};

}  // namespace sightline::apps
