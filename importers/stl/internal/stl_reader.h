// Reader of STL, text (stl_text.h) and binary. A file is binary when it is as long as its count says, else when it has
// bytes that no text has; its first word says nothing.
//
// The records of a binary file decide where count and length contradict each other: records beyond the count that look
// like facets are read, other bytes there are ignored, both with a warning; so is a count of more than there is. Damage
// is a file that ends within a facet. When lenient its whole facets are read, up to where records are no facets any
// more: bytes that are missing within a file displace all behind them.
//
// Why no library: admesh and VTK read from files alone, and convert text to float.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "sightline/importers/import.h"

namespace sightline::importers {

/// Peak memory of read_stl, the scene's included, stays below this many times the file's size plus kStlMemoryConstant,
/// whatever count the file claims.
inline constexpr std::size_t kStlMemoryFactor = 24;
inline constexpr std::size_t kStlMemoryConstant = std::size_t{1} << 20;

/// Reads a whole file image. `path` names the node. On error the scene is untouched. A file that is neither form is an
/// error, lenient or not. Time is linear in the file's size.
core::Expected<ImportReport> read_stl(std::span<const std::byte> bytes, const std::filesystem::path& path,
                                      core::Scene& scene, core::NodeId parent, const ImportOptions& options = {});

}  // namespace sightline::importers
