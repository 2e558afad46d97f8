#include "sightline/importers/internal/loaded_module.h"

#include <system_error>

#include <dlfcn.h>

namespace sightline::importers {
namespace {

namespace fs = std::filesystem;

fs::path folder_of_program() {
  std::error_code ignored;
  return fs::read_symlink("/proc/self/exe", ignored).parent_path();
}

/// The folder of the program or shared library that this code is part of.
fs::path folder_of_library() {
  Dl_info info{};
  if (dladdr(reinterpret_cast<const void*>(&folder_of_library), &info) == 0 || !info.dli_fname) return {};
  std::error_code ignored;
  return fs::weakly_canonical(info.dli_fname, ignored).parent_path();
}

}  // namespace

LoadedModule load_module(const char* file, const char* symbol) {
  std::error_code ignored;
  const fs::path program = folder_of_program();
  LoadedModule module;
  for (const fs::path& path : {program / file, program.parent_path() / "lib" / file, fs::path(file)}) {
    if (path.has_parent_path() && !fs::exists(path, ignored)) continue;
    // Never closed: what it links keeps state until the program ends.
    void* library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
    module.entry = library ? dlsym(library, symbol) : nullptr;
    if (module.entry) return module;
    const char* said = dlerror();
    module.error = said ? said : "it is none of ours";
  }
  return module;
}

std::optional<fs::path> find_program(const char* name) {
  std::error_code ignored;
  const fs::path program = folder_of_program(), library = folder_of_library(),
                 below = fs::path("libexec") / "sightline";
  for (const fs::path& folder : {program, program.parent_path() / below, library, library.parent_path() / below,
                                 library.parent_path().parent_path() / below, fs::path(SIGHTLINE_LIBEXEC_DIR)})
    if (!folder.empty() && fs::is_regular_file(folder / name, ignored)) return folder / name;
  return std::nullopt;
}

}  // namespace sightline::importers
