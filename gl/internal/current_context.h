// Which context is current on a thread, whoever made it and with whichever library. Internal to gl and engine.
#pragma once

#include <memory>

namespace sightline::gl {

/// Libraries that make contexts current. Each keeps an account of its own, although a thread has one context at most:
/// what one of Mesa's makes current replaces what another had, which goes unnoticed there, and libglvnd refuses. So
/// what the others have is released first.
enum class ContextLibrary : unsigned char { kNone, kEgl, kGlx, kOsMesa, kWgl };

/// Leaves no context of other libraries than this current on the calling thread, the application's included.
void release_other_contexts(ContextLibrary library);

/// Notes which context is current on the calling thread, and makes it current again when it is destroyed, with its
/// surfaces and EGL's bound API. A context that has been destroyed meanwhile stays out. Knows libraries that somebody
/// has opened by their usual names. Takes a microsecond, and where the context was changed the time of a change.
class CurrentContext {
 public:
  CurrentContext() : before_(look()) {}
  CurrentContext(const CurrentContext&) = delete;
  CurrentContext& operator=(const CurrentContext&) = delete;
  ~CurrentContext();

 private:
  struct Current {
    ContextLibrary library = ContextLibrary::kNone;
    void* context = nullptr;
    void* display = nullptr;  // EGL's or GLX's; WGL's context of drawing
    void* draw = nullptr;     // surfaces, of GLX as numbers; OSMesa's pixels
    void* read = nullptr;
    int type = 0, width = 0, height = 0;  // of OSMesa's pixels
    std::shared_ptr<void> ours;           // of OSMesa: keeps one that this library made

    bool operator==(const Current&) const = default;
  };
  static Current look();
  static void make_current(const Current& current);
  static unsigned egl_api();

  Current before_;
  unsigned egl_api_ = egl_api();
};

}  // namespace sightline::gl
