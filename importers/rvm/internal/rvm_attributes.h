// Reader of the attribute files that belong to RVM models (.txt, .att): text beside the geometry, one element per
// group.
//
//   CADC_Attributes_File v1.0 , start: NEW , end: END , name_end: := , sep: &end&
//   NEW /SITE
//     Type:= 'SITE'
//     NEW /SITE/PIPE-7
//       Bore:= 100 &end& Spec:= 'A1'
//     END
//   END
//
// The words for start, end, name_end and sep are those of the header. Values lose the quotes around them. An element's
// attributes go to the group of the same path of names, counted from the top groups of the file nodes below `parent`:
// of those whose file has the attribute file's stem where there are any (plant.rvm, plant.txt), else of all. The k-th
// of several siblings of one name meets the k-th. Elements above the top groups may lead to them; elements without a
// group (most have no geometry) are counted and left out.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "sightline/importers/import.h"

namespace sightline::importers {

/// Elements may nest so deep, and have so many attributes.
inline constexpr std::size_t kMaxAttributeDepth = 256;
inline constexpr std::size_t kMaxAttributesPerElement = 1024;

/// Adds no node. Damage (a line that is no attribute, END without NEW or missing, limits exceeded): an error naming
/// file and line when strict, and the scene is untouched; a warning when lenient. A file without the header's first
/// word is no attribute file, one of which no element finds its group belongs to another model: errors both.
core::Expected<ImportReport> read_rvm_attributes(std::span<const std::byte> bytes, const std::filesystem::path& path,
                                                 core::Scene& scene, core::NodeId parent,
                                                 const ImportOptions& options = {});

}  // namespace sightline::importers
