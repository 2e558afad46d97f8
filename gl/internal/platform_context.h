// Contexts that this library makes, by EGL or OSMesa, without linking either. Internal to gl.
#pragma once

#include <memory>
#include <string>

#include "sightline/core/error.h"
#include "sightline/gl/context.h"
#include "sightline/gl/functions.h"

namespace sightline::gl {

/// One context. Its destruction releases it on this thread; if it is current elsewhere, it lives on until released
/// there.
class PlatformContext {
 public:
  virtual ~PlatformContext() = default;
  /// Cheap when the context is already current. Fails when it is current on another thread.
  virtual core::Expected<void> make_current() const = 0;
  /// Leaves no context current on this thread, if this one is.
  virtual void release_current() const = 0;
  virtual Proc get_proc(const char* name) const = 0;
  /// "EGL surfaceless", "EGL device 0 (software)", "OSMesa"
  virtual std::string name() const = 0;
};

/// Makes a context and leaves it current on this thread. The error lists each platform tried and why it failed.
core::Expected<std::unique_ptr<PlatformContext>> create_egl_context(const ContextOptions& options);
/// The same with OSMesa. The error says what to install.
core::Expected<std::unique_ptr<PlatformContext>> create_osmesa_context(const ContextOptions& options);

// EGL and OSMesa do not know of each other, but Mesa's share one current context for each thread: what one makes
// current replaces the other's, which goes unnoticed there. So the other's is released first.

/// Leaves no EGL context current on this thread, the application's included. Does nothing if nobody has opened EGL.
void release_any_egl_context(const std::string& egl_library);
/// Leaves no OSMesa context current on this thread, if one of ours is.
void release_any_osmesa_context();

}  // namespace sightline::gl
