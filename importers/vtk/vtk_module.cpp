#include "sightline/importers/vtk/internal/vtk_module.h"

#include <fmt/format.h>

#include "sightline/importers/internal/loaded_module.h"

namespace sightline::importers {

core::Expected<ImportReport> read_vtk_by_module(std::span<const std::byte> bytes, const std::filesystem::path& path,
                                                core::Scene& scene, core::NodeId parent, const ImportOptions& options) {
  static const LoadedModule module = load_module("libsightline_vtk.so", "sightline_read_vtk");
  if (!module.entry)
    return core::fail(fmt::format("{}: VTK files need libsightline_vtk.so beside the program: {}",
                                  path.filename().string(), module.error));
  const auto read = *static_cast<decltype(&read_vtk_by_module) const*>(module.entry);
  return read(bytes, path, scene, parent, options);
}

}  // namespace sightline::importers
