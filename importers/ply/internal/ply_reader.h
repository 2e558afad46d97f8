// Reader of PLY (G. Turk, "The PLY Polygon File Format", 1994): text, binary little-endian and big-endian.
//
// A node named after the file holds one mesh item. Its vertices are the element "vertex": x, y, z of any scalar type,
// kept in double relative to the mesh's centre; nx, ny, nz. Its faces are the elements "face" (vertex_indices or
// vertex_index, any list types) and "tristrips" (-1 ends a strip). Names count in any case. Colours (red, green, blue,
// alpha; else diffuse_red and so on; else r, g, b, a; whole numbers up to 255, 65535 for 16 bits, floats up to 1)
// become materials. Face colours give one item per colour; beyond kMostFaceColours colours their average counts. Where
// faces have no colours, each has the mean of its vertices'. An alpha of 0 throughout is ignored: writers leave it so.
// Other properties are skipped, other elements, too, with a warning. A file without faces (a scan's points) gives a
// node without items and a warning.
//
// In text an element is a line. Read with one warning for each kind: numbers or words behind an element's own, comments
// and empty lines among the data, an element that goes on in the next line, header lines without a keyword, a byte
// order mark, words or nothing in place of numbers other than coordinates and corners. A normal that is not finite
// becomes that of the faces about its vertex.
//
// Damage is: data that end before the header's counts are met; a face whose vertex does not exist; a coordinate that is
// not there or not a number; in text a list that is not as long as it says. It is an error when strict. When lenient it
// is a warning: the data end there, the face is left out, the coordinate is NaN; text is read on with the next line,
// and a line without any number is no element. Faces with corners that are not finite or beyond 1e36 are dropped and
// listed. Names of textures are not followed.
//
// Why no library: Debian packages neither tinyply nor RPly; assimp and VTK convert positions to float.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "sightline/importers/import.h"

namespace sightline::importers {

/// Peak memory of read_ply, the scene's included, stays below this many times the file's size plus kPlyMemoryConstant,
/// whatever counts the file claims.
inline constexpr std::size_t kPlyMemoryFactor = 48;
inline constexpr std::size_t kPlyMemoryConstant = std::size_t{1} << 20;

/// Reads a whole file image. `path` names the node. On error the scene is untouched. A header that cannot be read, or
/// one without vertices with x, y and z, is an error, lenient or not. Time is linear in the file's size, except for
/// large polygons (triangulate.h).
core::Expected<ImportReport> read_ply(std::span<const std::byte> bytes, const std::filesystem::path& path,
                                      core::Scene& scene, core::NodeId parent, const ImportOptions& options = {});

}  // namespace sightline::importers
