#include "sightline/gl/internal/current_context.h"

#include <cstdint>
#include <initializer_list>
#include <mutex>
#include <optional>

#include "sightline/gl/internal/dynamic_library.h"
#include "sightline/gl/internal/platform_context.h"

namespace sightline::gl {
namespace {

// Handles are pointers and numbers here, and constants are named: a build needs no header of GLX and OSMesa.
constexpr int kEglDraw = 0x3059, kEglRead = 0x305A;  // EGL_DRAW, EGL_READ
constexpr unsigned kEglFirstApi = 0x30A0;            // EGL_OPENGL_ES_API, which is bound at first
constexpr int kOsMesaType = 0x23;                    // OSMESA_TYPE

struct CurrentEgl {
  static constexpr std::initializer_list<const char*> kNames = {"libEGL.so.1"};
  void* (*GetCurrentContext)();
  void* (*GetCurrentDisplay)();
  void* (*GetCurrentSurface)(int which);
  unsigned (*MakeCurrent)(void* display, void* draw, void* read, void* context);
  unsigned (*QueryAPI)();
  unsigned (*BindAPI)(unsigned api);

  bool load(void* library) {
    return find_symbol(library, "eglGetCurrentContext", GetCurrentContext) &&
           find_symbol(library, "eglGetCurrentDisplay", GetCurrentDisplay) &&
           find_symbol(library, "eglGetCurrentSurface", GetCurrentSurface) &&
           find_symbol(library, "eglMakeCurrent", MakeCurrent) && find_symbol(library, "eglQueryAPI", QueryAPI) &&
           find_symbol(library, "eglBindAPI", BindAPI);
  }
};

struct CurrentGlx {
  static constexpr std::initializer_list<const char*> kNames = {"libGLX.so.0", "libGL.so.1"};
  void* (*GetCurrentContext)();
  void* (*GetCurrentDisplay)();
  unsigned long (*GetCurrentDrawable)();
  unsigned long (*GetCurrentReadDrawable)();
  int (*MakeContextCurrent)(void* display, unsigned long draw, unsigned long read, void* context);

  bool load(void* library) {
    return find_symbol(library, "glXGetCurrentContext", GetCurrentContext) &&
           find_symbol(library, "glXGetCurrentDisplay", GetCurrentDisplay) &&
           find_symbol(library, "glXGetCurrentDrawable", GetCurrentDrawable) &&
           find_symbol(library, "glXGetCurrentReadDrawable", GetCurrentReadDrawable) &&
           find_symbol(library, "glXMakeContextCurrent", MakeContextCurrent);
  }
};

/// On 64-bit Windows functions of the system are called as all others.
struct CurrentWgl {
  static constexpr std::initializer_list<const char*> kNames = {"opengl32.dll"};
  void* (*GetCurrentContext)();
  void* (*GetCurrentDC)();
  int (*MakeCurrent)(void* drawing, void* context);

  bool load(void* library) {
    return find_symbol(library, "wglGetCurrentContext", GetCurrentContext) &&
           find_symbol(library, "wglGetCurrentDC", GetCurrentDC) && find_symbol(library, "wglMakeCurrent", MakeCurrent);
  }
};

struct CurrentOsMesa {
  static constexpr std::initializer_list<const char*> kNames = {"libOSMesa.so.8", "libOSMesa.so.6"};
  void* (*GetCurrentContext)();
  unsigned char (*GetColorBuffer)(void* context, int* width, int* height, int* format, void** pixels);
  void (*GetIntegerv)(int name, int* value);
  unsigned char (*MakeCurrent)(void* context, void* pixels, unsigned type, int width, int height);

  bool load(void* library) {
    return find_symbol(library, "OSMesaGetCurrentContext", GetCurrentContext) &&
           find_symbol(library, "OSMesaGetColorBuffer", GetColorBuffer) &&
           find_symbol(library, "OSMesaGetIntegerv", GetIntegerv) &&
           find_symbol(library, "OSMesaMakeCurrent", MakeCurrent);
  }
};

/// The functions of a library that somebody has opened; null where nobody has. It stays open from then on.
template <class Entries>
const Entries* opened() {
  static std::mutex mutex;
  static std::optional<Entries> found;
  const std::lock_guard lock(mutex);
  if (found) return &*found;
  for (const char* name : Entries::kNames) {
    void* const library = core::platform::opened_module(name);
    Entries entries;
    if (library && entries.load(library)) return &found.emplace(entries);
  }
  return nullptr;
}

void* as_pointer(unsigned long drawable) {
  return reinterpret_cast<void*>(std::uintptr_t(drawable));
}
unsigned long as_drawable(void* pointer) {
  return static_cast<unsigned long>(reinterpret_cast<std::uintptr_t>(pointer));
}

}  // namespace

void release_other_contexts(ContextLibrary library) {
  const auto* egl = opened<CurrentEgl>();
  const auto* glx = opened<CurrentGlx>();
  const auto* osmesa = opened<CurrentOsMesa>();
  const bool egl_has = egl && egl->GetCurrentContext(), glx_has = glx && glx->GetCurrentContext();
  if (library != ContextLibrary::kOsMesa) {
    release_osmesa_context_of_ours();
    // While another library's context of Mesa's is current, OSMesa takes that for its own.
    if (osmesa && !egl_has && !glx_has && osmesa->GetCurrentContext()) osmesa->MakeCurrent(nullptr, nullptr, 0, 0, 0);
  }
  if (library != ContextLibrary::kEgl && egl_has) egl->MakeCurrent(egl->GetCurrentDisplay(), nullptr, nullptr, nullptr);
  if (const auto* wgl = opened<CurrentWgl>(); wgl && library != ContextLibrary::kWgl && wgl->GetCurrentContext())
    wgl->MakeCurrent(nullptr, nullptr);
  if (library != ContextLibrary::kGlx && glx_has) glx->MakeContextCurrent(glx->GetCurrentDisplay(), 0, 0, nullptr);
}

CurrentContext::~CurrentContext() {
  if (look() != before_) {
    release_other_contexts(before_.library);
    make_current(before_);
  }
  if (egl_api() != egl_api_) opened<CurrentEgl>()->BindAPI(egl_api_);
}

CurrentContext::Current CurrentContext::look() {
  Current current;
  if (const auto* egl = opened<CurrentEgl>(); egl && (current.context = egl->GetCurrentContext())) {
    current.library = ContextLibrary::kEgl;
    current.display = egl->GetCurrentDisplay();
    current.draw = egl->GetCurrentSurface(kEglDraw);
    current.read = egl->GetCurrentSurface(kEglRead);
  } else if (const auto* glx = opened<CurrentGlx>(); glx && (current.context = glx->GetCurrentContext())) {
    current.library = ContextLibrary::kGlx;
    current.display = glx->GetCurrentDisplay();
    current.draw = as_pointer(glx->GetCurrentDrawable());
    current.read = as_pointer(glx->GetCurrentReadDrawable());
  } else if (const auto* wgl = opened<CurrentWgl>(); wgl && (current.context = wgl->GetCurrentContext())) {
    current.library = ContextLibrary::kWgl;
    current.display = wgl->GetCurrentDC();
  } else if (const auto* osmesa = opened<CurrentOsMesa>(); osmesa && (current.context = osmesa->GetCurrentContext())) {
    current.library = ContextLibrary::kOsMesa;
    int format = 0;
    osmesa->GetColorBuffer(current.context, &current.width, &current.height, &format, &current.draw);
    osmesa->GetIntegerv(kOsMesaType, &current.type);
    current.ours = osmesa_context_of_ours();
  }
  return current;
}

void CurrentContext::make_current(const Current& current) {
  switch (current.library) {
    case ContextLibrary::kNone:
      return;
    case ContextLibrary::kEgl:
      opened<CurrentEgl>()->MakeCurrent(current.display, current.draw, current.read, current.context);
      return;
    case ContextLibrary::kGlx:
      opened<CurrentGlx>()->MakeContextCurrent(current.display, as_drawable(current.draw), as_drawable(current.read),
                                               current.context);
      return;
    case ContextLibrary::kWgl:
      opened<CurrentWgl>()->MakeCurrent(current.display, current.context);
      return;
    case ContextLibrary::kOsMesa:
      if (current.ours)
        make_current_again(current.ours);
      else
        opened<CurrentOsMesa>()->MakeCurrent(current.context, current.draw, unsigned(current.type), current.width,
                                             current.height);
  }
}

unsigned CurrentContext::egl_api() {
  const auto* egl = opened<CurrentEgl>();
  return egl ? egl->QueryAPI() : kEglFirstApi;
}

}  // namespace sightline::gl
