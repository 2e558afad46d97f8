// importers: bytes to scene and scene to bytes. Readers for AVEVA RVM (rvm_reader.h) and Wavefront OBJ (obj_reader.h),
// the RVM writer (rvm_writer.h), triangulation of facet polygons (triangulate.h), and the generator of synthetic
// plants.
//
// This header reads files of any known format. Readers never print, throw or exit. A failed import leaves the scene
// exactly as it was; a successful one can be committed (what is not finite, or larger than any site, was dropped and
// listed).
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "sightline/core/error.h"
#include "sightline/core/scene.h"

namespace sightline::importers {

/// Something a reader noticed and got over.
struct ImportWarning {
  std::string file;
  std::uint64_t offset = 0;  ///< bytes from the file's begin
  std::string message;       ///< one line
};

struct ImportOptions {
  /// Damaged files: false fails at the first damage, true imports what can be had and lists the damage as warnings.
  bool lenient = false;
};

/// Warnings kept per import; one more says how many were not.
inline constexpr std::size_t kMaxWarnings = 1000;

struct ImportReport {
  std::vector<core::NodeId> nodes;  ///< one per file, in order: children of the given parent, named after the file
  std::vector<ImportWarning> warnings;
  /// Items imported by kind as found in the file (an empty facet group counts as one), degenerate ones included.
  std::array<std::uint64_t, core::kKindCount> items{};
  std::uint64_t degenerate = 0;  ///< items without volume: no length for lines, no area for facets
  std::uint64_t bytes = 0;       ///< read from files
  double metres_per_unit = 1.0;  ///< of the last file's coordinates; the scene is in metres
};

/// Imports one file as a new child of `parent`, named after it; its format follows from the extension (.rvm, .obj, any
/// case). Errors name the file: unknown extension, missing, a directory, empty, unreadable, damaged.
core::Expected<ImportReport> import_file(const std::filesystem::path& path, core::Scene& scene, core::NodeId parent,
                                         const ImportOptions& options = {});

/// Imports several files, one node each. All or nothing: when one fails the nodes of those before it are removed.
core::Expected<ImportReport> import_files(std::span<const std::filesystem::path> paths, core::Scene& scene,
                                          core::NodeId parent, const ImportOptions& options = {});

}  // namespace sightline::importers
