// Internal to the importers: files of exact surfaces through Open CASCADE, in this process.
#pragma once

#include <filesystem>

#include "sightline/importers/import.h"

namespace sightline::importers {

/// Reads STEP, IGES or BREP as import.h has it. Not for hostile files: Open CASCADE may crash, never end, or take all
/// memory. cad_import.h reads in a process of its own. One at a time: what Open CASCADE keeps is global.
core::Expected<ImportReport> read_cad(const std::filesystem::path& path, core::Scene& scene, core::NodeId parent,
                                      const ImportOptions& options);

}  // namespace sightline::importers
