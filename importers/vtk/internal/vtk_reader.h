// Reader of VTK files: legacy .vtk, XML .vtp and .vtu, and .vtm (.vtmb) that name such files as blocks.
//
// Polygon data and unstructured grids are read, and the outer surface of the latter is kept; vtk_import.h says what
// becomes what. Images and structured grids hold no surface of their own and are refused; so are the parallel forms
// (.pvtp, ...). Blocks become nodes named by their "name". The files of blocks are looked for in the .vtm file's
// directory and below; a name that leads elsewhere is refused. A file that several blocks name is read once and its
// meshes are shared. Files that name themselves, directly or through others, are refused; so are more than
// kMaxVtkBlocks blocks.
//
// Damage: sizes and counts that contradict each other or the file, and everything that vtk_import.h leaves out. Memory:
// once decoded, arrays take at most kVtkDecodedFactor times the file (vtk_file.h), which bounds what compression may
// promise. With markup, cells, surface and meshes, memory is at most kVtkMemoryFactor times the larger of the file and
// of its decoded arrays, plus the constant.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "sightline/importers/import.h"

namespace sightline::importers {

inline constexpr std::size_t kMaxVtkBlocks = 100000;
inline constexpr std::size_t kVtkMemoryFactor = 100, kVtkMemoryConstant = std::size_t{1} << 24;

/// Reads a whole file image. `path` names the node; its extension tells the format of the bytes, and its directory
/// where side files lie. On error the scene is untouched.
core::Expected<ImportReport> read_vtk(std::span<const std::byte> bytes, const std::filesystem::path& path,
                                      core::Scene& scene, core::NodeId parent, const ImportOptions& options = {});

}  // namespace sightline::importers
