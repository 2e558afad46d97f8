// Functions of libraries that are opened at run time. Internal to gl.
#pragma once

#include <dlfcn.h>

namespace sightline::gl {

/// Puts the address of the library's function `name` into `function`, a pointer to a function. Returns whether it has
/// one; `function` is null otherwise.
template <class Function>
bool find_symbol(void* library, const char* name, Function& function) {
  function = reinterpret_cast<Function>(dlsym(library, name));
  return function != nullptr;
}

}  // namespace sightline::gl
