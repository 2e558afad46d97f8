// importers: bytes to scene and scene to bytes. A folder per format holds its reader (rvm/, obj/, …) and writer; plant/
// is the generator of synthetic plants; triangulate.h covers polygons with triangles.
//
// This header reads files of any format that the build knows. Readers never print, throw or exit. A failed or cancelled
// import leaves the scene exactly as it was; a successful one can be committed (what is not finite, or larger than any
// site, was dropped and listed).
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
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

/// Which axis of a file points up. Scenes have z up.
enum class UpAxis : std::uint8_t { kY, kZ };

/// Meshes of a file that are taken for copies of one another.
enum class MeshCopies : std::uint8_t {
  kApart,    ///< none
  kExact,    ///< equal to the bit: what is written back is what was read
  kSimilar,  ///< those that differ by a similarity: moved, turned, scaled by one factor, up to the file's rounding
};

struct ImportOptions {
  /// Damaged files: false fails at the first damage, true imports what can be had and lists the damage as warnings.
  bool lenient = false;
  /// Length of a coordinate's unit, finite and > 0, for formats that name none: OBJ, PLY, STL, VTK. RVM and glTF say
  /// it.
  double metres_per_unit = 1.0;
  /// The same for what points up.
  UpAxis up = UpAxis::kZ;
  /// Which meshes are kept once (mesh_sharing.h). Costs a few nanoseconds a vertex.
  MeshCopies copies = MeshCopies::kSimilar;
  /// Threads for several files; 0: one for each processor.
  int threads = 0;
  /// Called now and then by the thread that imports with the share that is done, rising from 0 to 1. Answering false
  /// cancels, unless all is done (1): the import fails with kCancelled as its message.
  std::function<bool(double)> progress = {};
};

inline constexpr std::string_view kCancelled = "cancelled";

/// Warnings kept per import; one more says how many were not.
inline constexpr std::size_t kMaxWarnings = 1000;

struct ImportReport {
  std::vector<core::NodeId>
      nodes;  ///< one per model file, in order: children of the given parent, named after the file
  std::vector<ImportWarning> warnings;
  /// Items by kind as found in the file (an empty facet group counts as one), degenerate ones included.
  std::array<std::uint64_t, core::kKindCount> items{};
  std::uint64_t degenerate = 0;     ///< items without volume: no length for lines, no area for facets
  std::uint64_t shared_meshes = 0;  ///< mesh items that use a mesh which another one brought
  std::uint64_t attributed = 0;     ///< groups that an attribute file gave attributes to
  double sharing_error = 0.0;       ///< metres: no vertex of those lies farther from where the file has
                                    ///< it (a scale that glTF instances add is not counted)
  std::uint64_t bytes = 0;          ///< read from files
  double metres_per_unit = 1.0;     ///< of the last file's coordinates; the scene is in metres
};

/// Extensions that import_file() knows in this build, with dots, in lower case.
std::span<const std::string_view> known_extensions();

/// Imports one file as a new child of `parent`, named after it; its format follows from the extension (any case). An
/// attribute file (.txt, .att) adds no node: it speaks of RVM groups that are there (rvm/rvm_attributes.h).
/// Errors name the file: unknown extension, missing, a directory, empty, unreadable, damaged.
core::Expected<ImportReport> import_file(const std::filesystem::path& path, core::Scene& scene, core::NodeId parent,
                                         const ImportOptions& options = {});

/// Imports several files, one node each; attribute files last, wherever they stand. All or nothing: when one fails
/// those before it are taken back (but for attributes of groups that were there before).
core::Expected<ImportReport> import_files(std::span<const std::filesystem::path> paths, core::Scene& scene,
                                          core::NodeId parent, const ImportOptions& options = {});

}  // namespace sightline::importers
