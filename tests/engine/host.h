// An application with something current on its thread, which it made without this library.
#pragma once

#include <memory>
#include <string>

namespace sightline::tests {

class Host {
 public:
  virtual ~Host() = default;
  /// Empty: all is as the application left it.
  virtual std::string what_changed() const = 0;
};

/// With a context of the system's own library, EGL or on Windows WGL; null where there can be none.
std::unique_ptr<Host> make_system_host();
/// Whether the system's own library has a context current on this thread.
bool system_context_is_current();

}  // namespace sightline::tests
