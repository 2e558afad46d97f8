// Offscreen EGL contexts without linking EGL. Internal to gl.
#pragma once

#include <string>

#include "sightline/core/error.h"
#include "sightline/gl/context.h"
#include "sightline/gl/functions.h"

namespace sightline::gl {

/// One EGL context. Handles are void* so that users need no EGL header.
struct EglContext {
  void* library = nullptr;  ///< from dlopen, never closed: drivers do not survive being unloaded
  void* display = nullptr;
  void* context = nullptr;
  void* (*current)() = nullptr;  ///< eglGetCurrentContext; the only call needed when the context is already current
  std::string platform;          ///< "EGL surfaceless", "EGL device 0 (software)"
};

/// Makes a context and leaves it current on this thread. The error lists each platform tried and why it failed.
core::Expected<EglContext> create_egl_context(const ContextOptions& options);
/// Destroys the context. The display stays initialised: EGL shares it among all contexts of the process.
void destroy_egl_context(const EglContext& egl);
/// Cheap when the context is already current.
core::Expected<void> make_egl_current(const EglContext& egl);
/// Leaves no context current on this thread, if this one is.
void release_egl_current(const EglContext& egl);
/// A GetProc; `user` is the library handle.
Proc egl_get_proc(const char* name, void* library);

}  // namespace sightline::gl
