// Internal to the importers: files of exact surfaces through Open CASCADE, in this process.
#pragma once

#include <cstdint>
#include <filesystem>

#include "sightline/importers/import.h"

namespace sightline::importers {

/// How much of a file is read. Shapes alone are triangles, without names, colours, layers, properties and parts in
/// other files: they are a file's last chance where Open CASCADE fails at more.
enum class CadDetail : std::uint8_t { kAll, kShapesAlone };

/// Reads STEP, IGES or BREP as import.h has it. Not for hostile files: Open CASCADE may crash, never end, or take all
/// memory. cad_import.h reads in a process of its own. One at a time: what Open CASCADE keeps is global. Where Open
/// CASCADE throws while it reads all, it reads the shapes alone, with a warning.
core::Expected<ImportReport> read_cad(const std::filesystem::path& path, core::Scene& scene, core::NodeId parent,
                                      const ImportOptions& options, CadDetail detail = CadDetail::kAll);

}  // namespace sightline::importers
