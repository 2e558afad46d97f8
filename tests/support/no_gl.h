// When tests that draw may be skipped.
#pragma once

#include <cstdlib>
#include <string>

namespace sightline::tests {

/// SIGHTLINE_REQUIRE_GL is set to other than 0: this machine should have what drawing needs and cannot pass by
/// skipping.
inline bool gl_required() {
  const char* required = std::getenv("SIGHTLINE_REQUIRE_GL");
  return required && std::string(required) != "0";
}

/// Whether `error`, of gl::Context::create_offscreen() or on a tool's stderr, lets a test be skipped: it says that
/// there is no EGL or OSMesa, or none that gave a context ("no EGL: …", "EGL: …"), and GL is not required. All other
/// errors are failures.
inline bool may_skip(const std::string& error) {
  if (gl_required()) return false;
  for (const char* reason : {"no EGL: ", "EGL: ", "no OSMesa: ", "OSMesa: "})
    if (error.rfind(reason, 0) == 0 || error.find(std::string(": ") + reason) != std::string::npos) return true;
  return false;
}

}  // namespace sightline::tests
