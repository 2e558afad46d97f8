// Functions of libraries that are opened at run time. Internal to gl.
#pragma once

#include "sightline/core/internal/platform/modules.h"

namespace sightline::gl {

/// Puts the address of the library's function `name` into `function`, a pointer to a function. Returns whether it has
/// one; `function` is null otherwise.
template <class Function>
bool find_symbol(void* library, const char* name, Function& function) {
  function = reinterpret_cast<Function>(core::platform::find_in_module(library, name));
  return function != nullptr;
}

}  // namespace sightline::gl
