// Reader of VTK files: legacy .vtk, XML .vtp and .vtu, and .vtm (.vtmb) that name such files as blocks.
//
// Read are polygon data and unstructured grids, whose outer surface is kept; vtk_import.h says what becomes what.
// Images and structured grids hold no surface of their own and are refused; so are the parallel forms (.pvtp, ...).
// Blocks become nodes named as their "name" says. The files of blocks are looked for in the .vtm file's directory and
// below, a name that leads elsewhere is refused; one that several blocks name is read once and its meshes shared. Files
// that name themselves, through others or not, are refused, as are more than kMaxVtkBlocks blocks.
//
// Damage: sizes and counts that contradict each other or the file, and everything that vtk_import.h leaves out.
// Memory: arrays take at most kVtkDecodedFactor times the file once decoded (vtk_file.h), which bounds what compression
// may promise; with markup, cells, surface and meshes at most kVtkMemoryFactor times the larger of the file and of its
// decoded arrays, plus the constant.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "sightline/importers/import.h"

namespace sightline::importers {

inline constexpr std::size_t kMaxVtkBlocks = 100000;
inline constexpr std::size_t kVtkMemoryFactor = 100, kVtkMemoryConstant = std::size_t{1} << 24;

/// Reads a whole file image; `path` names the node, says by its extension what the bytes are, and where side files
/// lie. On error the scene is untouched.
core::Expected<ImportReport> read_vtk(std::span<const std::byte> bytes, const std::filesystem::path& path,
                                      core::Scene& scene, core::NodeId parent, const ImportOptions& options = {});

}  // namespace sightline::importers
