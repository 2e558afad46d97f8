// Contexts that this library makes, by EGL, WGL or OSMesa, without linking any. Internal to gl.
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
  /// "EGL surfaceless", "EGL device 0 (software)", "WGL", "OSMesa"
  virtual std::string name() const = 0;
};

/// Makes a context by the system's own means, EGL or on Windows WGL, and leaves it current on this thread. The error
/// lists each platform tried and why it failed.
core::Expected<std::unique_ptr<PlatformContext>> create_system_context(const ContextOptions& options);
/// Creates a context with OSMesa. The error says what to install.
core::Expected<std::unique_ptr<PlatformContext>> create_osmesa_context(const ContextOptions& options);

// OSMesa does not keep on which thread a context is current. Of those that this library made, the following know it.

/// The one that is current on this thread; null where none is.
std::shared_ptr<void> osmesa_context_of_ours();
/// Leaves it current no longer.
void release_osmesa_context_of_ours();
/// Makes it current on this thread, unless it has been destroyed meanwhile.
void make_current_again(const std::shared_ptr<void>& osmesa_context_of_ours);

}  // namespace sightline::gl
