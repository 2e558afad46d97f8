#include "sightline/importers/internal/loaded_module.h"

#include <system_error>

#include "sightline/core/internal/platform/modules.h"
#include "sightline/core/internal/platform/process.h"

namespace sightline::importers {
namespace {

namespace fs = std::filesystem;

fs::path folder_of_program() {
  return core::platform::program_file().parent_path();
}

/// The folder of the program or shared library that this code is part of.
fs::path folder_of_library() {
  const fs::path file = core::platform::module_of(reinterpret_cast<const void*>(&folder_of_library));
  if (file.empty()) return {};
  std::error_code ignored;
  return fs::weakly_canonical(file, ignored).parent_path();
}

}  // namespace

LoadedModule load_module(const char* file, const char* symbol) {
  std::error_code ignored;
  const fs::path program = folder_of_program();
  LoadedModule module;
  for (const fs::path& path : {program / file, program.parent_path() / "lib" / file, fs::path(file)}) {
    if (path.has_parent_path() && !fs::exists(path, ignored)) continue;
    const auto library = core::platform::open_module(path);
    module.entry = library ? core::platform::find_in_module(*library, symbol) : nullptr;
    if (module.entry) return module;
    const std::string said = library ? core::platform::symbol_error() : library.error().message;
    module.error = said.empty() ? "it is none of ours" : said;
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
