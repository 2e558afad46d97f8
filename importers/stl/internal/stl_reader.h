// Reader of STL, binary and text ("StereoLithography Interface Specification", 3D Systems, 1989).
//
// A file is binary when its size says so (84 bytes and 50 for each facet), whatever its first word; else text when it
// begins with "solid" and holds no zero byte early on. Corners at exactly the same position are welded, in double for
// text; stored normals are ignored, since their facets' corners say the same. A text file's solids become nodes of
// their names below a node named after the file (a solid without a name: that node itself), with a mesh item each; a
// binary file is one mesh. Of the attribute bytes colours are read in both usual forms: after "COLOR=" in the header a
// default colour, and facets with bit 15 clear have their own, red lowest (Magics); without it facets with bit 15 set
// have one, blue lowest (VisCAM). Each colour becomes an item, beyond kMostFaceColours their average.
//
// Damage: bytes missing or left over; in text anything but facets of three corners between "solid" and "endsolid". An
// error when strict; when lenient a warning, and the facets that are whole are kept. Facets with corners that are not
// finite or beyond 1e36 are dropped and listed. No facets: a warning, and no item.
//
// An own reader: admesh and VTK read from files alone, and convert text to float.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "sightline/importers/import.h"

namespace sightline::importers {

/// Memory that read_stl allocates at its peak, the scene's included, stays below this many times the file's size plus
/// kStlMemoryConstant, whatever count the file claims.
inline constexpr std::size_t kStlMemoryFactor = 24;
inline constexpr std::size_t kStlMemoryConstant = std::size_t{1} << 20;

/// Reads a whole file image; `path` names the node. On error the scene is untouched. A file that is neither form is an
/// error, lenient or not. Linear in the file's size.
core::Expected<ImportReport> read_stl(std::span<const std::byte> bytes, const std::filesystem::path& path,
                                      core::Scene& scene, core::NodeId parent, const ImportOptions& options = {});

}  // namespace sightline::importers
