#define EGL_NO_PLATFORM_SPECIFIC_TYPES
#include <algorithm>
#include <array>
#include <filesystem>
#include <string_view>
#include <vector>

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <fmt/format.h>

#include "sightline/core/internal/platform/files.h"
#include "sightline/gl/internal/current_context.h"
#include "sightline/gl/internal/dynamic_library.h"
#include "sightline/gl/internal/platform_context.h"

namespace sightline::gl {
namespace {

constexpr const char* kEglHint = "install libegl1 and a driver such as libgl1-mesa-dri";

/// The EGL entry points used here.
struct Egl {
  PFNEGLGETPROCADDRESSPROC GetProcAddress = nullptr;
  PFNEGLQUERYSTRINGPROC QueryString = nullptr;
  PFNEGLGETERRORPROC GetError = nullptr;
  PFNEGLINITIALIZEPROC Initialize = nullptr;
  PFNEGLBINDAPIPROC BindAPI = nullptr;
  PFNEGLQUERYAPIPROC QueryAPI = nullptr;
  PFNEGLCHOOSECONFIGPROC ChooseConfig = nullptr;
  PFNEGLCREATECONTEXTPROC CreateContext = nullptr;
  PFNEGLDESTROYCONTEXTPROC DestroyContext = nullptr;
  PFNEGLMAKECURRENTPROC MakeCurrent = nullptr;
  PFNEGLGETCURRENTCONTEXTPROC GetCurrentContext = nullptr;
  PFNEGLGETPLATFORMDISPLAYEXTPROC GetPlatformDisplay = nullptr;
  PFNEGLQUERYDEVICESEXTPROC QueryDevices = nullptr;            // may be null
  PFNEGLQUERYDEVICESTRINGEXTPROC QueryDeviceString = nullptr;  // may be null
};

template <class Function>
bool find_extension(const Egl& egl, const char* name, Function& function) {
  function = reinterpret_cast<Function>(egl.GetProcAddress(name));
  return function != nullptr;
}

core::Expected<Egl> load_egl(void* library) {
  Egl egl;
  const bool core_found =
      find_symbol(library, "eglGetProcAddress", egl.GetProcAddress) &&
      find_symbol(library, "eglQueryString", egl.QueryString) && find_symbol(library, "eglGetError", egl.GetError) &&
      find_symbol(library, "eglInitialize", egl.Initialize) && find_symbol(library, "eglBindAPI", egl.BindAPI) &&
      find_symbol(library, "eglQueryAPI", egl.QueryAPI) && find_symbol(library, "eglChooseConfig", egl.ChooseConfig) &&
      find_symbol(library, "eglCreateContext", egl.CreateContext) &&
      find_symbol(library, "eglDestroyContext", egl.DestroyContext) &&
      find_symbol(library, "eglMakeCurrent", egl.MakeCurrent) &&
      find_symbol(library, "eglGetCurrentContext", egl.GetCurrentContext);
  if (!core_found) return core::fail("EGL: the library lacks entry points of EGL 1.4");
  if (!find_extension(egl, "eglGetPlatformDisplayEXT", egl.GetPlatformDisplay)) {
    return core::fail("EGL: EGL_EXT_platform_base is required");
  }
  find_extension(egl, "eglQueryDevicesEXT", egl.QueryDevices);
  find_extension(egl, "eglQueryDeviceStringEXT", egl.QueryDeviceString);
  return egl;
}

/// Whether a space-separated list holds exactly this name. The list may be null.
bool has_extension(const char* list, std::string_view name) {
  std::string_view rest = list ? list : "";
  while (!rest.empty()) {
    const std::size_t end = rest.find(' ');
    if (rest.substr(0, end) == name) return true;
    rest = end == std::string_view::npos ? std::string_view() : rest.substr(end + 1);
  }
  return false;
}

std::string egl_error(const Egl& egl) {
  const EGLint error = egl.GetError();
  switch (error) {
    case EGL_NOT_INITIALIZED:
      return "EGL_NOT_INITIALIZED";
    case EGL_BAD_ACCESS:
      return "EGL_BAD_ACCESS";
    case EGL_BAD_ALLOC:
      return "EGL_BAD_ALLOC";
    case EGL_BAD_ATTRIBUTE:
      return "EGL_BAD_ATTRIBUTE";
    case EGL_BAD_CONFIG:
      return "EGL_BAD_CONFIG";
    case EGL_BAD_DISPLAY:
      return "EGL_BAD_DISPLAY";
    case EGL_BAD_MATCH:
      return "EGL_BAD_MATCH";
    case EGL_BAD_PARAMETER:
      return "EGL_BAD_PARAMETER";
    case EGL_SUCCESS:
      return "no reason given";
    default:
      return fmt::format("EGL error {:#06x}", error);
  }
}

/// A way to get a display.
struct Candidate {
  EGLenum platform = EGL_NONE;
  EGLDeviceEXT device = nullptr;  ///< null for surfaceless
  bool software = false;
  std::string name;
};

std::vector<Candidate> list_devices(const Egl& egl, int only) {
  std::vector<Candidate> candidates;
  std::array<EGLDeviceEXT, 32> devices{};
  EGLint count = 0;
  if (!egl.QueryDevices || !egl.QueryDevices(static_cast<EGLint>(devices.size()), devices.data(), &count)) return {};
  for (EGLint i = 0; i < count; ++i) {
    if (only >= 0 && i != only) continue;
    const EGLDeviceEXT device = devices[static_cast<std::size_t>(i)];
    const char* extensions = egl.QueryDeviceString ? egl.QueryDeviceString(device, EGL_EXTENSIONS) : nullptr;
    const bool software = has_extension(extensions, "EGL_MESA_device_software");
    candidates.push_back(
        {EGL_PLATFORM_DEVICE_EXT, device, software, fmt::format("EGL device {}{}", i, software ? " (software)" : "")});
  }
  return candidates;
}

/// Platforms to try, best first: a hardware device beats whatever the surfaceless platform picks.
std::vector<Candidate> list_candidates(const Egl& egl, const ContextOptions& options) {
  const char* extensions = egl.QueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  std::vector<Candidate> candidates;
  std::vector<Candidate> devices;
  if (options.platform != ContextPlatform::kEglSurfaceless && has_extension(extensions, "EGL_EXT_platform_device")) {
    devices = list_devices(egl, options.platform == ContextPlatform::kEglDevice ? options.device : -1);
  }
  for (const Candidate& device : devices) {
    if (!device.software) candidates.push_back(device);
  }
  if (options.platform != ContextPlatform::kEglDevice && has_extension(extensions, "EGL_MESA_platform_surfaceless")) {
    candidates.push_back({EGL_PLATFORM_SURFACELESS_MESA, nullptr, false, "EGL surfaceless"});
  }
  for (const Candidate& device : devices) {
    if (device.software) candidates.push_back(device);
  }
  return candidates;
}

core::Expected<EGLConfig> choose_config(const Egl& egl, EGLDisplay display, const char* extensions) {
  if (has_extension(extensions, "EGL_KHR_no_config_context")) return EGLConfig(EGL_NO_CONFIG_KHR);
  // No surface is ever made, so any configuration that OpenGL can use will do.
  const EGLint attributes[] = {EGL_SURFACE_TYPE, EGL_DONT_CARE, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
  EGLConfig config = nullptr;
  EGLint count = 0;
  if (egl.ChooseConfig(display, attributes, &config, 1, &count) && count > 0) return config;
  return core::fail("no EGL configuration for OpenGL");
}

core::Expected<EGLContext> create_context(const Egl& egl, EGLDisplay display, bool debug) {
  const char* extensions = egl.QueryString(display, EGL_EXTENSIONS);
  if (!has_extension(extensions, "EGL_KHR_surfaceless_context")) {
    return core::fail("EGL_KHR_surfaceless_context is absent");
  }
  auto config = choose_config(egl, display, extensions);
  if (!config) return tl::unexpected(config.error());
  // The last pair requests reset notification, which not every driver offers.
  std::array attributes = {EGL_CONTEXT_MAJOR_VERSION_KHR,
                           kRequiredMajor,
                           EGL_CONTEXT_MINOR_VERSION_KHR,
                           kRequiredMinor,
                           EGL_CONTEXT_OPENGL_PROFILE_MASK_KHR,
                           EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT_KHR,
                           EGL_CONTEXT_FLAGS_KHR,
                           debug ? EGL_CONTEXT_OPENGL_DEBUG_BIT_KHR : 0,
                           EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY_KHR,
                           EGL_LOSE_CONTEXT_ON_RESET_KHR,
                           EGL_NONE};
  EGLContext context = egl.CreateContext(display, *config, EGL_NO_CONTEXT, attributes.data());
  if (context == EGL_NO_CONTEXT) {
    attributes[attributes.size() - 3] = EGL_NONE;
    context = egl.CreateContext(display, *config, EGL_NO_CONTEXT, attributes.data());
  }
  if (context != EGL_NO_CONTEXT) return context;
  return core::fail(fmt::format("no OpenGL {}.{} core context: {}", kRequiredMajor, kRequiredMinor, egl_error(egl)));
}

class EglContext final : public PlatformContext {
 public:
  EglContext(const Egl& egl, EGLDisplay display, EGLContext context, std::string name)
      : egl_(egl), display_(display), context_(context), name_(std::move(name)) {}
  EglContext(const EglContext&) = delete;
  EglContext& operator=(const EglContext&) = delete;
  /// The display stays initialised: EGL shares it among all contexts of the process.
  ~EglContext() override {
    EglContext::release_current();
    egl_.DestroyContext(display_, context_);
  }

  core::Expected<void> make_current() const override {
    if (egl_.GetCurrentContext() == context_) return {};
    release_other_contexts(ContextLibrary::kEgl);
    egl_.BindAPI(EGL_OPENGL_API);
    if (egl_.MakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_)) return {};
    return core::fail("eglMakeCurrent: " + egl_error(egl_));
  }

  void release_current() const override {
    const EGLenum bound = egl_.QueryAPI();  // perhaps the application's
    egl_.BindAPI(EGL_OPENGL_API);
    if (egl_.GetCurrentContext() == context_)
      egl_.MakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    egl_.BindAPI(bound);
  }

  Proc get_proc(const char* name) const override { return egl_.GetProcAddress(name); }
  std::string name() const override { return name_; }

 private:
  Egl egl_;
  EGLDisplay display_;
  EGLContext context_;
  std::string name_;
};

core::Expected<std::unique_ptr<PlatformContext>> try_candidate(const Egl& egl, const Candidate& candidate, bool debug) {
  const EGLDisplay display = egl.GetPlatformDisplay(
      candidate.platform, candidate.device ? candidate.device : static_cast<void*>(EGL_DEFAULT_DISPLAY), nullptr);
  if (display == EGL_NO_DISPLAY) return core::fail("no display: " + egl_error(egl));
  EGLint major = 0;
  EGLint minor = 0;
  if (!egl.Initialize(display, &major, &minor)) return core::fail("eglInitialize: " + egl_error(egl));
  if (!egl.BindAPI(EGL_OPENGL_API)) return core::fail("desktop OpenGL is not offered: " + egl_error(egl));
  auto context = create_context(egl, display, debug);
  if (!context) return tl::unexpected(context.error());
  auto made = std::make_unique<EglContext>(egl, display, *context, candidate.name);
  if (auto current = made->make_current(); !current) return tl::unexpected(current.error());
  return made;
}

core::Expected<void*> open_library(const std::string& name) {
  return core::platform::open_module(core::platform::path_of(name));
}

}  // namespace

bool has_gpu() {
  // Without a node of a driver, EGL finds none, and asking it takes longer than all else.
  constexpr std::array kNodes = {"/dev/dri", "/dev/nvidiactl", "/dev/dxg"};
  std::error_code ignored;
  if (std::ranges::none_of(kNodes, [&](const char* node) { return std::filesystem::exists(node, ignored); }))
    return false;
  const auto library = open_library(ContextOptions().egl_library);
  const auto egl = library ? load_egl(*library) : tl::unexpected(core::Error{});
  return egl && std::ranges::any_of(list_devices(*egl, -1), [](const Candidate& device) { return !device.software; });
}

core::Expected<std::unique_ptr<PlatformContext>> create_system_context(const ContextOptions& options) {
  if (options.platform == ContextPlatform::kWgl) return core::fail("no WGL: it is Windows' alone; expected egl or osmesa");
  const auto library = open_library(options.egl_library);
  if (!library) {
    const std::string& reason = library.error().message;
    return core::fail(fmt::format("no EGL: {}; tried {} ({})", kEglHint, options.egl_library,
                                  reason.empty() ? "no reason given" : reason));
  }
  auto egl = load_egl(*library);
  if (!egl) return core::fail(fmt::format("{}; tried {}; {}", egl.error().message, options.egl_library, kEglHint));

  std::string tried;
  for (const Candidate& candidate : list_candidates(*egl, options)) {
    auto context = try_candidate(*egl, candidate, options.debug);
    if (context) return context;
    tried += fmt::format("{}{}: {}", tried.empty() ? "" : "; ", candidate.name, context.error().message);
  }
  if (tried.empty()) tried = "none, the library offers no such platform or device";
  return core::fail(
      fmt::format("EGL: no platform gave a context; {}; tried {} ({})", kEglHint, tried, options.egl_library));
}

}  // namespace sightline::gl
