// Reader of Wavefront OBJ with MTL.
//
// A node named after the file holds one node per object (`o`), and each of these one per group (`g`) in it: groups of
// one name in two objects are two nodes. An object of a name that was there is another one where it brings vertices. A
// new object ends the group. A group name is the rest of its line, spaces included. Each node holds one mesh item per
// material. Positions are read in double and kept relative to the centre of their mesh, which becomes the item's
// placement. Faces become triangles (any polygon, see triangulate.h). Where a mesh has normals, corners without one get
// that of their face. Coordinates are in ImportOptions::metres_per_unit, metres unless set.
//
// Materials keep Kd and d (or 1 - Tr; Tr itself in libraries of MeshLab and VTK, which write opacity there). Kd is
// multiplied by the mean of the texture (map_Kd, PNG or JPEG) and by the mean of the colours that the item's vertices
// have (v x y z r g b, up to 1 or up to 255; not where all are black beside a material, which some writers fill up
// with). A material without Kd is 0.8 grey, or the texture's mean; one with a texture below a black Kd shows the
// texture alone, with a warning. A material that would hide its faces (d 0 or Tr 1, which many writers mean as opaque)
// is opaque, with a warning. usemtl may come before the mtllib that it needs. Smoothing and what concerns display is
// ignored.
//
// Lines end with LF, CR or CR LF, and a backslash continues them. '#' begins a comment; in names only where it stands
// by itself. The file may be in UTF-8 (with or without byte order mark) or UTF-16; names that are not UTF-8 are taken
// for Windows-1252, with a warning.
//
// Damage is a face with a vertex that does not exist or is no number. It is an error naming the line when strict; when
// lenient it is a warning and the face is left out. All else is a counted warning with the first line, strict or not:
// vertices that are not three finite numbers within 1e36 (decimal commas, "nan") with the faces that have them, faces
// of fewer than three corners, normals that do not exist or are no direction (these lose themselves alone), colours
// that are no numbers, lines, points, free-form shapes and unknown words.
//
// An MTL file is looked for in the OBJ file's directory and below: the rest of the mtllib line as one name, then names
// up to ".mtl", then words; each as written, with '\' as '/', with %20 decoded; at last by a similar name, with a
// warning (side_files.h). A name that leads elsewhere is refused with a warning, a missing file is a warning.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "sightline/importers/import.h"

namespace sightline::importers {

/// Peak memory of read_obj, the scene's included, stays below this many times the bytes of the OBJ file and its MTL
/// files together, plus kObjMemoryConstant. A model takes about ten times; the worst case is a file of tiny groups. A
/// texture adds 4 bytes per pixel while it is looked at.
inline constexpr std::size_t kObjMemoryFactor = 256;
inline constexpr std::size_t kObjMemoryConstant = std::size_t{1} << 20;

/// Reads a whole file image. `path` names the node and says where MTL files lie. On error the scene is untouched. A
/// file without a single vertex statement is not an OBJ file: an error, lenient or not.
core::Expected<ImportReport> read_obj(std::span<const std::byte> bytes, const std::filesystem::path& path,
                                      core::Scene& scene, core::NodeId parent, const ImportOptions& options = {});

}  // namespace sightline::importers
