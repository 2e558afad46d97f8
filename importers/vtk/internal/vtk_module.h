// Internal to the importers: the VTK reader, loaded with the first file that needs it. VTK's shared libraries take 9 ms
// to load, which a tool whose scene has no VTK file does not pay.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "sightline/importers/import.h"

namespace sightline::importers {

/// Calls read_vtk() (vtk_reader.h) of libsightline_vtk.so. Looks for that file beside the program, in lib/ beside its
/// directory, and where the system keeps libraries. Fails when it is not there.
core::Expected<ImportReport> read_vtk_by_module(std::span<const std::byte> bytes, const std::filesystem::path& path,
                                                core::Scene& scene, core::NodeId parent, const ImportOptions& options);

}  // namespace sightline::importers
