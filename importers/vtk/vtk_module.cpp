#include "sightline/importers/vtk/internal/vtk_module.h"

#include <string>
#include <system_error>

#include <dlfcn.h>
#include <fmt/format.h>

namespace sightline::importers {
namespace {

namespace fs = std::filesystem;
using Read = decltype(&read_vtk_by_module);

struct Module {
  Read read = nullptr;
  std::string error;
};

Module load() {
  constexpr const char* kName = "libsightline_vtk.so";
  std::error_code ignored;
  const fs::path program = fs::read_symlink("/proc/self/exe", ignored).parent_path();
  Module module;
  for (const fs::path& path : {program / kName, program.parent_path() / "lib" / kName, fs::path(kName)}) {
    if (path.has_parent_path() && !fs::exists(path, ignored)) continue;
    // Never closed: VTK keeps state until the program ends.
    void* library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
    const void* entry = library ? dlsym(library, "sightline_read_vtk") : nullptr;
    if (entry) module.read = *static_cast<const Read*>(entry);
    if (module.read) return module;
    const char* said = dlerror();
    module.error = said ? said : "it is none of ours";
  }
  return module;
}

}  // namespace

core::Expected<ImportReport> read_vtk_by_module(std::span<const std::byte> bytes, const fs::path& path,
                                                core::Scene& scene, core::NodeId parent, const ImportOptions& options) {
  static const Module module = load();
  if (!module.read)
    return core::fail(fmt::format("{}: VTK files need libsightline_vtk.so beside the program: {}",
                                  path.filename().string(), module.error));
  return module.read(bytes, path, scene, parent, options);
}

}  // namespace sightline::importers
