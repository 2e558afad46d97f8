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
// The header defines the words for start, end, name_end and sep. Values lose the quotes around them. An element's
// attributes go to the group with the same names from the top down, counted from the top groups of the file nodes below
// `parent`. If the file of any of these nodes has the attribute file's stem (plant.rvm, plant.txt), only such nodes
// count, else all. The k-th of several siblings of one name gets the attributes of the k-th. Elements above the top
// groups may lead to them. Elements without a group (most have no geometry) are counted and left out.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "sightline/importers/import.h"

namespace sightline::importers {

/// Limits of the nesting of elements, and of their attributes.
inline constexpr std::size_t kMaxAttributeDepth = 256;
inline constexpr std::size_t kMaxAttributesPerElement = 1024;

/// Adds no node. Damage is a line that is not an attribute, END without NEW or a missing END, and exceeded limits. When
/// strict it is an error naming file and line, and the scene is untouched; when lenient, a warning. A file without the
/// header's first word is not an attribute file. A file of which no element finds its group belongs to another model.
/// Both are errors.
core::Expected<ImportReport> read_rvm_attributes(std::span<const std::byte> bytes, const std::filesystem::path& path,
                                                 core::Scene& scene, core::NodeId parent,
                                                 const ImportOptions& options = {});

}  // namespace sightline::importers
