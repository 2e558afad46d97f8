// Internal to the importers: what lies beside a program and is loaded or started with the first file that needs it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace sightline::importers {

/// A symbol of a shared library, or why there is none. The library is never closed.
struct LoadedModule {
  const void* entry = nullptr;
  std::string error;
};
/// Looks for the file beside the program, in lib/ beside its directory, and where the system keeps libraries.
LoadedModule load_module(const char* file, const char* symbol);

/// A program of ours: beside the running one, in libexec/sightline/ beside its directory or beside this library's, or
/// where the build installs it.
std::optional<std::filesystem::path> find_program(const char* name);

}  // namespace sightline::importers
