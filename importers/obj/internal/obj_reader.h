// Reader of Wavefront OBJ with MTL, over tinyobjloader.
//
// A node named after the file holds one node per distinct object or group name (the latest of `o` and `g` names what
// follows). Each of these holds one mesh item per material. Positions are read in double and kept relative to the
// centre of their mesh, which becomes the item's placement. Faces become triangles (any polygon, see triangulate.h).
// Normals are kept when all corners of a mesh have one. Materials keep Kd and d (or 1 - Tr). A material that would hide
// its faces (d 0 or Tr 1, which many writers mean as opaque) is opaque, with a warning. Coordinates are in
// ImportOptions::metres_per_unit, metres unless set. Lines, points, textures and curves are ignored.
//
// Damage is a face whose vertex or normal does not exist. It is an error naming the line when strict; when lenient it
// is a warning and the face is left out. Faces with corners that are not finite or beyond 1e36 are dropped and listed.
// An MTL file is looked for in the OBJ file's directory and below. A name that leads elsewhere is refused with a
// warning, a missing file is a warning.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "sightline/importers/import.h"

namespace sightline::importers {

/// Peak memory of read_obj, the scene's included, stays below this many times the bytes of the OBJ file and its MTL
/// files together, plus kObjMemoryConstant. A model takes about ten times; the worst case is a file of empty materials,
/// for each of which the library keeps 2 kB.
inline constexpr std::size_t kObjMemoryFactor = 800;
inline constexpr std::size_t kObjMemoryConstant = std::size_t{1} << 20;

/// Reads a whole file image. `path` names the node and says where MTL files lie. On error the scene is untouched. A
/// file without a single vertex statement is not an OBJ file: an error, lenient or not.
core::Expected<ImportReport> read_obj(std::span<const std::byte> bytes, const std::filesystem::path& path,
                                      core::Scene& scene, core::NodeId parent, const ImportOptions& options = {});

}  // namespace sightline::importers
