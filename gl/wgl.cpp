// Contexts of Windows' own library. Built on Windows in place of egl.cpp and osmesa.cpp.
#include <array>
#include <future>
#include <string_view>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "sightline/core/internal/platform/windows.h"
#include "sightline/gl/internal/current_context.h"
#include "sightline/gl/internal/dynamic_library.h"
#include "sightline/gl/internal/platform_context.h"

namespace sightline::gl {
namespace {

constexpr const char* kHint = "install the graphics card's own driver, or Mesa's opengl32.dll";
// From GL/wglext.h, which a build need not have.
constexpr int kMajorVersion = 0x2091, kMinorVersion = 0x2092, kFlags = 0x2094, kProfile = 0x9126;
constexpr int kDebugFlag = 1, kCoreProfile = 1;
constexpr int kResetNotification = 0x8256, kLoseContextOnReset = 0x8252;

/// The entry points used here.
struct Wgl {
  void* library = nullptr;
  HGLRC(WINAPI* CreateContext)(HDC) = nullptr;
  BOOL(WINAPI* DeleteContext)(HGLRC) = nullptr;
  BOOL(WINAPI* MakeCurrent)(HDC, HGLRC) = nullptr;
  HGLRC(WINAPI* GetCurrentContext)() = nullptr;
  PROC(WINAPI* GetProcAddress)(LPCSTR) = nullptr;

  /// The library itself has those of OpenGL 1.1, and the driver the others.
  Proc find(const char* name) const {
    const PROC proc = GetProcAddress(name);
    // Some drivers answer with small numbers instead of null.
    const auto number = reinterpret_cast<std::intptr_t>(proc);
    if (number < -1 || number > 3) return reinterpret_cast<Proc>(proc);
    return reinterpret_cast<Proc>(core::platform::find_in_module(library, name));
  }
};

core::Expected<Wgl> load_wgl() {
  const auto opened = core::platform::open_module("opengl32.dll");
  if (!opened) return core::fail(fmt::format("no opengl32.dll ({})", opened.error().message));
  Wgl wgl;
  wgl.library = *opened;
  const bool found = find_symbol(wgl.library, "wglCreateContext", wgl.CreateContext) &&
                     find_symbol(wgl.library, "wglDeleteContext", wgl.DeleteContext) &&
                     find_symbol(wgl.library, "wglMakeCurrent", wgl.MakeCurrent) &&
                     find_symbol(wgl.library, "wglGetCurrentContext", wgl.GetCurrentContext) &&
                     find_symbol(wgl.library, "wglGetProcAddress", wgl.GetProcAddress);
  return found ? core::Expected<Wgl>(wgl) : core::fail("opengl32.dll lacks entry points");
}

std::string last_error() {
  return core::platform::words_of(core::platform::last_error());
}

// --- windows that nobody sees ----------------------------------------------------------------------------------------

constexpr UINT kMakeWindow = WM_APP, kDestroyWindow = WM_APP + 1;
constexpr const wchar_t* kClass = L"SightlineOffscreen";

HWND make_window(HWND parent) {
  return CreateWindowExW(0, kClass, L"", parent ? 0 : WS_CLIPSIBLINGS | WS_CLIPCHILDREN, 0, 0, 1, 1, parent, nullptr,
                         GetModuleHandleW(nullptr), nullptr);
}

LRESULT CALLBACK answer(HWND window, UINT message, WPARAM first, LPARAM second) {
  if (message == kMakeWindow) return LRESULT(make_window(nullptr));
  if (message == kDestroyWindow) return DestroyWindow(HWND(second));
  return DefWindowProcW(window, message, first, second);
}

/// Only the thread that made a window may destroy it. So one thread makes those of all contexts, at the request of a
/// window of its own, which this is. It lasts as long as the process. Null where there can be none.
HWND window_maker() {
  static const HWND maker = [] {
    std::promise<HWND> made;
    auto result = made.get_future();
    std::thread([&made] {
      WNDCLASSW kind{};
      kind.style = CS_OWNDC;  // so that a window's context of drawing goes with any thread
      kind.lpfnWndProc = answer;
      kind.hInstance = GetModuleHandleW(nullptr);
      kind.lpszClassName = kClass;
      RegisterClassW(&kind);
      made.set_value(make_window(HWND_MESSAGE));
      MSG message;
      while (GetMessageW(&message, nullptr, 0, 0) > 0) DispatchMessageW(&message);
    }).detach();
    return result.get();
  }();
  return maker;
}

/// A window that is never shown, in a format that OpenGL can use.
class HiddenWindow {
 public:
  static core::Expected<HiddenWindow> create() {
    HiddenWindow made;
    const HWND maker = window_maker();
    if (maker) made.window_ = HWND(SendMessageW(maker, kMakeWindow, 0, 0));
    if (made.window_) made.drawing_ = GetDC(made.window_);
    if (!made.drawing_) return core::fail("no window can be made");
    PIXELFORMATDESCRIPTOR format{};
    format.nSize = sizeof format;
    format.nVersion = 1;
    format.dwFlags = PFD_DRAW_TO_WINDOW | PFD_SUPPORT_OPENGL;
    format.iPixelType = PFD_TYPE_RGBA;
    format.cColorBits = 24;
    const int chosen = ChoosePixelFormat(made.drawing_, &format);
    if (chosen == 0 || !SetPixelFormat(made.drawing_, chosen, &format))
      return core::fail("no pixel format for OpenGL: " + last_error());
    return made;
  }
  HiddenWindow(HiddenWindow&& other) noexcept
      : window_(std::exchange(other.window_, nullptr)), drawing_(std::exchange(other.drawing_, nullptr)) {}
  HiddenWindow& operator=(HiddenWindow&&) = delete;
  ~HiddenWindow() {
    if (drawing_) ReleaseDC(window_, drawing_);
    if (window_) SendMessageW(window_maker(), kDestroyWindow, 0, LPARAM(window_));
  }
  HDC drawing() const { return drawing_; }

 private:
  HiddenWindow() = default;
  HWND window_ = nullptr;
  HDC drawing_ = nullptr;
};

// --- contexts --------------------------------------------------------------------------------------------------------

class WglContext final : public PlatformContext {
 public:
  WglContext(const Wgl& wgl, HiddenWindow window, HGLRC context)
      : wgl_(wgl), window_(std::move(window)), context_(context) {}
  WglContext(const WglContext&) = delete;
  WglContext& operator=(const WglContext&) = delete;
  ~WglContext() override {
    WglContext::release_current();
    wgl_.DeleteContext(context_);
  }

  core::Expected<void> make_current() const override {
    if (wgl_.GetCurrentContext() == context_) return {};
    release_other_contexts(ContextLibrary::kWgl);
    if (wgl_.MakeCurrent(window_.drawing(), context_)) return {};
    return core::fail("wglMakeCurrent: " + last_error());
  }
  void release_current() const override {
    if (wgl_.GetCurrentContext() == context_) wgl_.MakeCurrent(nullptr, nullptr);
  }
  Proc get_proc(const char* name) const override { return wgl_.find(name); }
  std::string name() const override { return "WGL"; }

 private:
  Wgl wgl_;
  HiddenWindow window_;
  HGLRC context_;
};

/// A context of any version tells how to make one of a certain version.
core::Expected<HGLRC> create_context(const Wgl& wgl, HDC drawing, bool debug) {
  const HGLRC any = wgl.CreateContext(drawing);
  if (!any) return core::fail("wglCreateContext: " + last_error());
  const CurrentContext kept;
  release_other_contexts(ContextLibrary::kWgl);
  wgl.MakeCurrent(drawing, any);
  HGLRC(WINAPI * create)(HDC, HGLRC, const int*) = nullptr;
  create = reinterpret_cast<decltype(create)>(wgl.find("wglCreateContextAttribsARB"));
  // The last pair requests reset notification, which not every driver offers.
  std::array attributes = {
      kMajorVersion, kRequiredMajor,         kMinorVersion,      kRequiredMinor,      kProfile, kCoreProfile,
      kFlags,        debug ? kDebugFlag : 0, kResetNotification, kLoseContextOnReset, 0};
  HGLRC context = create ? create(drawing, nullptr, attributes.data()) : nullptr;
  if (create && !context) {
    attributes[attributes.size() - 3] = 0;
    context = create(drawing, nullptr, attributes.data());
  }
  const std::string why = create ? last_error() : "the driver has no wglCreateContextAttribsARB, as Windows' own";
  wgl.MakeCurrent(nullptr, nullptr);
  wgl.DeleteContext(any);
  if (context) return context;
  return core::fail(fmt::format("no OpenGL {}.{} core context: {}", kRequiredMajor, kRequiredMinor, why));
}

core::Expected<std::unique_ptr<PlatformContext>> try_wgl(bool debug) {
  const auto wgl = load_wgl();
  if (!wgl) return tl::unexpected(wgl.error());
  auto window = HiddenWindow::create();
  if (!window) return tl::unexpected(window.error());
  const auto context = create_context(*wgl, window->drawing(), debug);
  if (!context) return tl::unexpected(context.error());
  auto made = std::make_unique<WglContext>(*wgl, std::move(*window), *context);
  if (auto current = made->make_current(); !current) return tl::unexpected(current.error());
  return made;
}

}  // namespace

bool has_gpu() {
  DISPLAY_DEVICEW device{};
  device.cb = sizeof device;
  for (DWORD i = 0; EnumDisplayDevicesW(nullptr, i, &device, 0); ++i) {
    const bool basic = std::wstring_view(device.DeviceString).starts_with(L"Microsoft Basic");
    if ((device.StateFlags & DISPLAY_DEVICE_ATTACHED_TO_DESKTOP) != 0 && !basic) return true;
  }
  return false;
}

core::Expected<std::unique_ptr<PlatformContext>> create_system_context(const ContextOptions& options) {
  if (options.platform != ContextPlatform::kAutomatic && options.platform != ContextPlatform::kWgl)
    return core::fail("no EGL on Windows");
  auto context = try_wgl(options.debug);
  if (context) return context;
  return core::fail(fmt::format("WGL: {}; {}", context.error().message, kHint));
}

core::Expected<std::unique_ptr<PlatformContext>> create_osmesa_context(const ContextOptions&) {
  return core::fail("no OSMesa on Windows");
}
std::shared_ptr<void> osmesa_context_of_ours() {
  return nullptr;
}
void release_osmesa_context_of_ours() {}
void make_current_again(const std::shared_ptr<void>&) {}

}  // namespace sightline::gl
