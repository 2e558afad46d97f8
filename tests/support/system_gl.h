// The libraries by which an application has contexts, without this one.
#pragma once

#include "sightline/core/internal/platform/modules.h"
#include "sightline/gl/context.h"
#include "sightline/gl/functions.h"

namespace sightline::tests {

/// A library, and its function that finds functions of OpenGL.
struct GlLibrary {
  const char* file;
  const char* finder;
};
inline constexpr GlLibrary kOsMesaLibrary{"libOSMesa.so.8", "OSMesaGetProcAddress"};
#ifdef _WIN32
inline constexpr auto kSystemPlatform = gl::ContextPlatform::kWgl;
inline constexpr GlLibrary kSystemLibrary{"opengl32.dll", "wglGetProcAddress"};
#else
inline constexpr auto kSystemPlatform = gl::ContextPlatform::kEgl;
inline constexpr GlLibrary kSystemLibrary{"libEGL.so.1", "eglGetProcAddress"};
#endif
inline constexpr bool kHasOsMesa = kSystemPlatform == gl::ContextPlatform::kEgl;  // Windows has neither

/// Null where there is none. WGL's own library has the functions of OpenGL 1.1, and finds the others.
inline gl::Proc foreign_proc(const GlLibrary& library, const char* name) {
  static const auto find = [](void* module, const char* symbol) {
    return reinterpret_cast<gl::Proc>(core::platform::find_in_module(module, symbol));
  };
  const auto module = core::platform::open_module(library.file);
  if (!module) return nullptr;
  const auto finder = reinterpret_cast<gl::Proc (*)(const char*)>(find(*module, library.finder));
  const gl::Proc found = finder ? finder(name) : nullptr;
  return found ? found : find(*module, name);
}

}  // namespace sightline::tests
