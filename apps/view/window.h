// The window of sightline-view: GLFW and an OpenGL context.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sightline/apps/view/events.h"
#include "sightline/core/error.h"
#include "sightline/gl/context.h"
#include "sightline/gl/internal/framebuffer.h"
#include "sightline/gl/internal/texture.h"
#include "sightline/render/image/image.h"

struct GLFWwindow;

namespace sightline::apps {

/// Part of a framebuffer, pixels from its lower left corner.
struct Part {
  int x = 0, y = 0, width = 0, height = 0;
  friend bool operator==(const Part&, const Part&) = default;
};

class Window {
 public:
  /// Opens a window with an OpenGL 4.5 core context and makes it current on this thread. The context is robust where
  /// the platform offers that. `size`: in screen units. With `vsync`, present() waits for the screen. Without a display
  /// or such a context it fails with GLFW's reason. Only one window may be open at a time.
  static core::Expected<Window> open(const std::string& title, const std::array<int, 2>& size, bool vsync);
  /// Makes window and context anew, in the same place and size: for a context that was lost. What lay in the former one
  /// is gone. Fails where no context can be had; then nothing has changed.
  core::Expected<void> reopen();

  const gl::Context& context() const { return state_->context.value(); }
  gl::Context& context() { return state_->context.value(); }
  /// Size of its framebuffer, in pixels; 0 while minimised.
  std::array<int, 2> size() const;
  std::array<int, 2> screen_size() const;       ///< the same in screen units
  void resize(const std::array<int, 2>& size);  ///< screen units
  double scale() const;                         ///< of text and lines: 1 on a screen of 96 dots per inch
  void set_title(const std::string& title);
  std::string clipboard() const;
  void set_clipboard(const std::string& text);

  bool closing() const;
  void close();
  void keep_open();  ///< somebody has tried to close it, and is asked
  /// What has happened since the last call. Waits for it for some seconds at most; while the window is minimised until
  /// it no longer is.
  std::vector<Event> poll(double wait);
  /// Makes poll() return at once; from any thread.
  static void wake();

  /// Copies a framebuffer object of that size into the back buffer; stretched where the part has another size.
  void copy(std::uint32_t framebuffer, const std::array<int, 2>& size, const Part& to) {
    copy(framebuffer, size, to, 0, size[0]);
  }
  /// Copies the columns from `begin` to before `end` alone, which get their part of `to`.
  void copy(std::uint32_t framebuffer, const std::array<int, 2>& size, const Part& to, int begin, int end);
  /// Keeps an image in the context, in place of another one; null: none.
  core::Expected<void> keep(const image::Image* image);
  bool keeps_image() const { return state_->kept.framebuffer.id() != 0; }
  /// Copies the image that is kept.
  void copy_kept(const Part& to);
  void clear(const core::vec3& colour);
  image::Image read() const;  ///< the back buffer
  void present();

 private:
  struct State {
    State() = default;
    State(const State&) = delete;
    State& operator=(const State&) = delete;
    ~State();
    core::Expected<void> open(const std::array<int, 2>& size);

    std::string title;
    bool vsync = true;
    GLFWwindow* window = nullptr;
    std::optional<gl::Context> context;
    struct Kept {
      gl::Texture2D texture;
      gl::Framebuffer framebuffer;
    } kept;  // in the context
    std::vector<Event> events;
  };
  explicit Window(std::unique_ptr<State> state) : state_(std::move(state)) {}

  std::unique_ptr<State> state_;  // at a fixed address: GLFW's callbacks point to it
};

}  // namespace sightline::apps
