// Libraries that are opened at run time. Internal.
#pragma once

#include <filesystem>
#include <string>

#include "sightline/core/api.h"
#include "sightline/core/error.h"

namespace sightline::core::platform {

/// Opens a library: that of a path with a folder, or one that the system looks for. It is never closed: leak checkers,
/// drivers' exit handlers and what libraries keep need their code to stay in place. An error has the system's reason
/// alone; it may be empty.
SIGHTLINE_API Expected<void*> open_module(const std::filesystem::path& file);

/// A library that somebody in this process has opened; null where nobody has. It stays open from then on.
SIGHTLINE_API void* opened_module(const std::filesystem::path& file);

/// The address of a module's symbol; null where it has none.
SIGHTLINE_API void* find_in_module(void* module, const char* symbol);
/// Why find_in_module() has just found none on this thread; may be empty.
SIGHTLINE_API std::string symbol_error();

/// The program or library that the code at this address is part of; empty where it cannot be told.
SIGHTLINE_API std::filesystem::path module_of(const void* address);

}  // namespace sightline::core::platform
