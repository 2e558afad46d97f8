#define EGL_NO_PLATFORM_SPECIFIC_TYPES
#include <EGL/egl.h>
#include <EGL/eglext.h>

#include "sightline/gl/internal/dynamic_library.h"
#include "sightline/tests/engine/host.h"

namespace sightline::tests {
namespace {

/// A context of OpenGL ES, with another surface to draw to than to read from.
class EglHost final : public Host {
 public:
  ~EglHost() override {
    if (display_ == EGL_NO_DISPLAY) return;
    make_current_(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    destroy_context_(display_, context_);
    for (const EGLSurface surface : {draw_, read_}) destroy_surface_(display_, surface);
  }
  std::string what_changed() const override {
    if (query_api_() != EGL_OPENGL_ES_API) return "another API is bound";
    if (current_() != context_) return "another context is current";
    return surface_(EGL_DRAW) == draw_ && surface_(EGL_READ) == read_ ? "" : "other surfaces are current";
  }

  bool begin() {
    const auto egl = core::platform::open_module("libEGL.so.1");
    if (!egl) return false;
    PFNEGLGETPROCADDRESSPROC get_proc = nullptr;
    PFNEGLINITIALIZEPROC initialize = nullptr;
    PFNEGLCHOOSECONFIGPROC choose_config = nullptr;
    PFNEGLCREATECONTEXTPROC create_context = nullptr;
    PFNEGLCREATEPBUFFERSURFACEPROC create_surface = nullptr;
    PFNEGLBINDAPIPROC bind_api = nullptr;
    gl::find_symbol(*egl, "eglGetProcAddress", get_proc);
    gl::find_symbol(*egl, "eglInitialize", initialize);
    gl::find_symbol(*egl, "eglChooseConfig", choose_config);
    gl::find_symbol(*egl, "eglCreateContext", create_context);
    gl::find_symbol(*egl, "eglCreatePbufferSurface", create_surface);
    gl::find_symbol(*egl, "eglBindAPI", bind_api);
    gl::find_symbol(*egl, "eglQueryAPI", query_api_);
    gl::find_symbol(*egl, "eglMakeCurrent", make_current_);
    gl::find_symbol(*egl, "eglDestroyContext", destroy_context_);
    gl::find_symbol(*egl, "eglDestroySurface", destroy_surface_);
    gl::find_symbol(*egl, "eglGetCurrentContext", current_);
    gl::find_symbol(*egl, "eglGetCurrentSurface", surface_);
    if (!get_proc) return false;
    const auto get_display = reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(get_proc("eglGetPlatformDisplayEXT"));
    const EGLDisplay display = get_display(EGL_PLATFORM_SURFACELESS_MESA, nullptr, nullptr);
    if (display == EGL_NO_DISPLAY || !initialize(display, nullptr, nullptr) || !bind_api(EGL_OPENGL_ES_API))
      return false;
    const EGLint wanted[] = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE, EGL_OPENGL_ES2_BIT, EGL_NONE};
    EGLConfig config = nullptr;
    EGLint count = 0;
    if (!choose_config(display, wanted, &config, 1, &count) || count == 0) return false;
    const EGLint version[] = {EGL_CONTEXT_CLIENT_VERSION, 2, EGL_NONE},
                 size[] = {EGL_WIDTH, 8, EGL_HEIGHT, 8, EGL_NONE};
    context_ = create_context(display, config, EGL_NO_CONTEXT, version);
    draw_ = create_surface(display, config, size);
    read_ = create_surface(display, config, size);
    if (!make_current_(display, draw_, read_, context_)) return false;
    display_ = display;
    return true;
  }

 private:
  PFNEGLQUERYAPIPROC query_api_ = nullptr;
  PFNEGLMAKECURRENTPROC make_current_ = nullptr;
  PFNEGLDESTROYCONTEXTPROC destroy_context_ = nullptr;
  PFNEGLDESTROYSURFACEPROC destroy_surface_ = nullptr;
  PFNEGLGETCURRENTCONTEXTPROC current_ = nullptr;
  PFNEGLGETCURRENTSURFACEPROC surface_ = nullptr;
  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLContext context_ = EGL_NO_CONTEXT;
  EGLSurface draw_ = EGL_NO_SURFACE, read_ = EGL_NO_SURFACE;
};

}  // namespace

std::unique_ptr<Host> make_system_host() {
  auto host = std::make_unique<EglHost>();
  return host->begin() ? std::move(host) : nullptr;
}

bool system_context_is_current() {
  void* (*current)() = nullptr;
  void* const egl = core::platform::opened_module("libEGL.so.1");
  return egl && gl::find_symbol(egl, "eglGetCurrentContext", current) && current();
}

}  // namespace sightline::tests
