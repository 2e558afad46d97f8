// Reader of AVEVA review models (RVM), binary and as text (rvm_text.h): all eleven primitive kinds, groups, colours,
// obstruction and insulation volumes.
//
// What becomes what. A node named after the file holds the file's groups as nodes. The strings of HEAD and MODL and the
// reference point of each group stay as attributes (rvm_chunks.h lists the keys). PRIM becomes an item with the chunk's
// matrix as placement. Facet groups become meshes that keep their polygons. OBST and INSU items hang on an unnamed
// child node of their group, on core::kLayerObstruction or kLayerInsulation. Each pair of colour index and transparency
// becomes one core::Material, set on nodes and inherited by items. Its colour comes from a COLR chunk anywhere in the
// file, else from rvm_default_colour().
//
// Items with NaN or infinite numbers, or reaching beyond 1e36 m, are dropped and listed as a warning, strict or
// lenient. A CNTE without CNTB is a warning, too (real files have it). Any other inconsistency is damage. In strict
// mode it is an error that states file, byte offset, chunk and what was expected. In lenient mode it is a warning,
// after which reading goes on with the next chunk that can be trusted.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "sightline/importers/import.h"

namespace sightline::importers {

/// Peak memory of read_rvm, the scene's included, stays below this many times the file's size plus kRvmMemoryConstant,
/// whatever counts the file claims.
inline constexpr std::size_t kRvmMemoryFactor = 32;
/// The factor of files of text, whose numbers may take two bytes each.
inline constexpr std::size_t kRvmTextMemoryFactor = 128;
inline constexpr std::size_t kRvmMemoryConstant = std::size_t{1} << 20;

/// Reads a whole file image. `file_name` names the node and appears in messages. On error the scene is untouched.
/// Nesting depth is bounded by memory alone. Time is linear in the file's size, except for facet polygons (see
/// triangulate_polygon). Messages about a text name lines where those about a binary file name bytes. A file that does
/// not begin with a readable HEAD is not an RVM file: an error, lenient or not.
core::Expected<ImportReport> read_rvm(std::span<const std::byte> bytes, std::string_view file_name, core::Scene& scene,
                                      core::NodeId parent, const ImportOptions& options = {});

/// Colour of an index that the file does not define. These are the sixteen usual ones (1 grey, 2 red, 3 orange, 4
/// yellow, 5 green, 6 cyan, 7 blue, 8 violet, 9 brown, 10 white, 11 pink, 12 mauve, 13 turquoise, 14 indigo, 15
/// near-black, 16 magenta), softened to read well when shaded. Higher indices get muted hues a golden angle apart.
std::array<std::uint8_t, 3> rvm_default_colour(std::uint32_t index);

}  // namespace sightline::importers
