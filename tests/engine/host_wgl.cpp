#include "sightline/core/internal/platform/windows.h"
#include "sightline/gl/internal/dynamic_library.h"
#include "sightline/tests/engine/host.h"

namespace sightline::tests {
namespace {

/// A context of OpenGL 1.1, as any of Windows', for a window that is never shown.
class WglHost final : public Host {
 public:
  ~WglHost() override {
    if (context_) {
      make_current_(nullptr, nullptr);
      destroy_context_(context_);
    }
    if (window_) DestroyWindow(window_);
  }
  std::string what_changed() const override {
    if (current_() != context_) return "another context is current";
    return current_drawing_() == drawing_ ? "" : "another window is current";
  }

  bool begin() {
    const auto wgl = core::platform::open_module("opengl32.dll");
    HGLRC(WINAPI * create_context)(HDC) = nullptr;
    if (!wgl || !gl::find_symbol(*wgl, "wglCreateContext", create_context)) return false;
    gl::find_symbol(*wgl, "wglMakeCurrent", make_current_);
    gl::find_symbol(*wgl, "wglDeleteContext", destroy_context_);
    gl::find_symbol(*wgl, "wglGetCurrentContext", current_);
    gl::find_symbol(*wgl, "wglGetCurrentDC", current_drawing_);
    window_ = CreateWindowExW(0, L"STATIC", L"", WS_CLIPSIBLINGS | WS_CLIPCHILDREN, 0, 0, 8, 8, nullptr, nullptr,
                              GetModuleHandleW(nullptr), nullptr);
    drawing_ = window_ ? GetDC(window_) : nullptr;
    PIXELFORMATDESCRIPTOR format{};
    format.nSize = sizeof format;
    format.nVersion = 1;
    format.dwFlags = PFD_DRAW_TO_WINDOW | PFD_SUPPORT_OPENGL | PFD_DOUBLEBUFFER;
    format.cColorBits = 24;
    if (!drawing_ || !SetPixelFormat(drawing_, ChoosePixelFormat(drawing_, &format), &format)) return false;
    context_ = create_context(drawing_);
    return context_ && make_current_(drawing_, context_);
  }

 private:
  BOOL(WINAPI* make_current_)(HDC, HGLRC) = nullptr;
  BOOL(WINAPI* destroy_context_)(HGLRC) = nullptr;
  HGLRC(WINAPI* current_)() = nullptr;
  HDC(WINAPI* current_drawing_)() = nullptr;
  HWND window_ = nullptr;
  HDC drawing_ = nullptr;
  HGLRC context_ = nullptr;
};

}  // namespace

std::unique_ptr<Host> make_system_host() {
  auto host = std::make_unique<WglHost>();
  return host->begin() ? std::move(host) : nullptr;
}

bool system_context_is_current() {
  HGLRC(WINAPI * current)() = nullptr;
  void* const wgl = core::platform::opened_module("opengl32.dll");
  return wgl && gl::find_symbol(wgl, "wglGetCurrentContext", current) && current();
}

}  // namespace sightline::tests
