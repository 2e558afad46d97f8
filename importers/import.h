// importers: bytes to scene and scene to bytes. A folder per format holds its reader (rvm/, obj/, …) and writer. plant/
// is the generator of synthetic plants. triangulate.h covers polygons with triangles.
//
// This header reads files of any format that the build knows. Readers never print, throw or exit. A failed or cancelled
// import leaves the scene exactly as it was. The result of a successful one can be committed: items that are not
// finite, or larger than any site, were dropped and listed.
//
// All readers of other programs' files keep this rule:
// - What other programs habitually write is read, with a counted warning where it bends the specification. A strict
//   import refuses only what would give a wrong model.
// - What is secondary never costs geometry: a normal, texture coordinate, colour or material that cannot be read, or
//   one bad polygon among others, loses itself alone.
// - Nothing is left out or replaced in silence: a warning names the kind of thing, how often it came, and where first.
//   A result with nothing to draw says so.
// - A lenient import keeps all that lies outside the damage, and goes on at the next line, facet, element or chunk. It
//   invents no geometry and moves no part.
// - Names, attributes and messages are UTF-8: decoded from the encoding that the file states, from UTF-16 where it
//   begins with a byte order mark, else from Windows-1252, with a warning. A scene cache gives names as written.
// - Other files are looked for as they are named, with a backslash as '/', with percent codes decoded, and at last
//   under a similar name in the model's folder, with a warning; never outside that folder.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include "sightline/core/api.h"
#include "sightline/core/error.h"
#include "sightline/core/scene.h"

namespace sightline::importers {

/// Something that a reader noticed but that did not stop it.
struct ImportWarning {
  std::string file;
  std::uint64_t offset = 0;  ///< bytes from the file's begin
  std::string message;       ///< one line
};

/// Which axis of a file points up. Scenes have z up.
enum class UpAxis : std::uint8_t {
  kY,
  kZ,
  /// OBJ and PLY: what a comment at their begin says ("z up"). Else, of these and STL, y where the meshes stand on a
  /// base in y and on none in z; the file's node then turns them, and a warning of kSeemsYUp tells it. z otherwise. Of
  /// several such files of one import all are turned or none.
  kAutomatic,
};
/// Message of the warning.
inline constexpr std::string_view kSeemsYUp = "seems to have y up and is turned";

/// Which meshes of a file count as copies of one another.
enum class MeshCopies : std::uint8_t {
  kApart,    ///< none
  kExact,    ///< equal to the bit: writing back gives what was read
  kSimilar,  ///< those that differ by a similarity: moved, turned, scaled by one factor, up to the file's rounding
};

struct ImportOptions {
  /// For damaged files. False: fails at the first damage. True: imports what it can and lists the damage as warnings.
  bool lenient = false;
  /// Length of a coordinate's unit, finite and > 0, for formats that state none: OBJ, PLY, STL, VTK. RVM and glTF state
  /// it.
  double metres_per_unit = 1.0;
  /// The axis that points up, for the same formats.
  UpAxis up = UpAxis::kAutomatic;
  /// For the same formats, radians, 0 to pi: meshes without normals get those of smooth surfaces, broken at edges that
  /// are bent by more than this. 0: they are shown facet by facet. About 0.2 us a triangle, and 12 bytes a vertex.
  double crease_angle = 0.0;
  /// Which meshes are kept only once (mesh_sharing.h). Costs a few nanoseconds per vertex.
  MeshCopies copies = MeshCopies::kSimilar;
  /// Whether meshes become analytic primitives where they are the triangles of some: cylinders, snouts, tori, dishes,
  /// spheres, boxes, pyramids (docs/guide/recognition.md). What is not recognised stays a mesh.
  bool recognise = false;
  /// How far vertices may lie from a recognised surface, in metres, finite and >= 0; 0: what each mesh's own size,
  /// tessellation and rounding tell.
  double recognise_tolerance = 0.0;
  /// For exact surfaces (STEP, IGES, BREP), where they are of no primitive: how far triangles may lie from them, in
  /// metres, finite and >= 0; 0: 0.05 % of each part's diagonal. Measured, and meshed finer where it is missed
  /// (ExactSurfaceReport).
  double chord_tolerance = 0.0;
  /// For the same formats, radians, above 0 to pi: the largest angle between neighbouring facets of a curve.
  double chord_angle = std::numbers::pi / 15;
  /// Reads the same formats in this process. Open CASCADE, which reads them, may crash, never end or take all memory
  /// where a file is hostile or damaged; so a process of its own does it otherwise.
  bool in_process = false;
  /// Threads for several files, and for parts of STEP, IGES and BREP; 0: one for each processor.
  int threads = 0;
  /// Where import_files() keeps scene caches (docs/guide/scene-cache.md), made when absent; empty: none. An import of
  /// the same unchanged files with the same options then reads the cache instead, with the same result. A cache that is
  /// missing, older than a file, damaged or of another version is written anew. What goes wrong with it becomes a
  /// warning, never an error. Has no effect below a parent that is moved, on attribute files for groups that are in the
  /// scene already, and on indexes of several VTK files.
  std::filesystem::path cache_folder = {};
  /// Whether scene caches hold levels of detail (docs/guide/levels-of-detail.md), too. Where the cache has none, they
  /// are built, about 3 us a triangle on a core, and written before the import returns. Meshes then come with theirs.
  /// Has an effect only with `cache_folder`, and where the library builds levels.
  bool cached_levels = false;
  /// Called now and then by the importing thread with the share that is done, rising from 0 to 1. Returning false
  /// cancels the import, which then fails with kCancelled as its message; at 1, when all is done, it has no effect.
  std::function<bool(double)> progress = {};
};

inline constexpr std::string_view kCancelled = "cancelled";

/// Most warnings kept per import. One more tells how many were left out.
inline constexpr std::size_t kMaxWarnings = 1000;

/// Why a solid of a mesh, or a part of one, stayed triangles.
enum class Refusal : std::uint8_t {
  kOpen,         ///< not closed: some edge has no neighbour of the other direction
  kCavity,       ///< inside out, unlike the mesh as a whole
  kNoStructure,  ///< neither rings of vertices nor faces of a box or pyramid
  kOffSurface,   ///< rings, but of no primitive within the tolerance
  kBroken,       ///< triangles (not solids) with two equal corners or one that is not finite
};
inline constexpr std::size_t kRefusalCount = 5;
/// "open", "cavity", "no structure", "off surface", "broken".
SIGHTLINE_API std::string_view name_of(Refusal refusal);

/// What ImportOptions::recognise did. Meshes count once, however many items share them.
struct RecognitionReport {
  std::uint64_t meshes = 0;                                      ///< looked at
  std::array<std::uint64_t, core::kPrimitiveKindCount> items{};  ///< primitive items made, by kind
  std::uint64_t triangles_before = 0, triangles_after = 0;
  std::uint64_t bytes_before = 0, bytes_after = 0;  ///< of vertices, normals, indices; of parameters afterwards
  double largest_deviation = 0.0;  ///< metres between triangles and what replaces them, both ways, in the scene; exact
                                   ///< to 5 % where placements are similarities, elsewhere a bound
  std::array<std::uint64_t, kRefusalCount> refused{};  ///< solids by Refusal, those recognised in part included
};

/// What became of exact surfaces: STEP, IGES, BREP (docs/guide/step.md). Parts count once, however often they are used.
struct ExactSurfaceReport {
  std::uint64_t parts = 0, instances = 0;
  std::uint64_t analytic_solids = 0;  ///< that became primitives
  std::uint64_t meshed_bodies = 0;    ///< other solids, shells and loose faces
  std::uint64_t triangles = 0;
  std::uint64_t failed_faces = 0;             ///< that could not be meshed
  std::uint64_t curves = 0, annotations = 0;  ///< not read
  double largest_tolerance = 0.0;             ///< of any part, metres
  double deviation = 0.0;                     ///< metres: the largest distance found between triangles and surfaces
  double analytic_deviation = 0.0;            ///< metres: no primitive lies farther from its solid's surfaces
};

struct ImportReport {
  std::vector<core::NodeId>
      nodes;  ///< one per model file, in order: children of the given parent, named after the file (.slc: as written)
  std::vector<ImportWarning> warnings;
  /// Items by kind as found in the file (an empty facet group counts as one), degenerate ones included. With
  /// ImportOptions::recognise, recognised meshes are not among them, but what they became.
  std::array<std::uint64_t, core::kKindCount> items{};
  std::uint64_t degenerate = 0;     ///< items without volume: no length for lines, no area for facets
  std::uint64_t shared_meshes = 0;  ///< mesh items that use a mesh which another item brought
  std::uint64_t attributed = 0;     ///< groups that an attribute file gave attributes to
  double sharing_error = 0.0;  ///< metres: no vertex of those meshes lies farther from where the file has it (a scale
                               ///< of glTF instances is not counted)
  std::uint64_t bytes = 0;     ///< read from files
  std::vector<std::filesystem::path> side_files;  ///< that the model files name: there or not, each once or more
  RecognitionReport recognition;                  ///< with ImportOptions::recognise
  ExactSurfaceReport surfaces;                    ///< of STEP, IGES and BREP
  bool from_cache = false;                        ///< a scene cache was read instead of the files
  double metres_per_unit = 1.0;                   ///< of the last file's coordinates; the scene is in metres
};

/// Extensions that import_file() knows in this build, with dots, in lower case.
SIGHTLINE_API std::span<const std::string_view> known_extensions();
/// Whether a file has attributes alone (.txt, .att; any case), which belong to the groups of a model.
SIGHTLINE_API bool is_attribute_file(const std::filesystem::path& file);

/// Imports one file as a new child of `parent`, named after it. Its format follows from the extension (any case). An
/// attribute file (.txt, .att) adds no node: it adds attributes to RVM groups that are in the scene already
/// (rvm/rvm_attributes.h). A scene cache (.slc) gives the nodes that were written, under their names. Errors name the
/// file: unknown extension, missing, a directory, empty, unreadable, damaged, or a metres_per_unit out of its range.
SIGHTLINE_API core::Expected<ImportReport> import_file(const std::filesystem::path& path, core::Scene& scene,
                                                       core::NodeId parent, const ImportOptions& options = {});

/// Imports several files, one node each. Attribute files are read last, wherever they stand in the list. All or
/// nothing: when one fails, those before it are taken back (except for attributes of groups that were there before).
SIGHTLINE_API core::Expected<ImportReport> import_files(std::span<const std::filesystem::path> paths,
                                                        core::Scene& scene, core::NodeId parent,
                                                        const ImportOptions& options = {});

}  // namespace sightline::importers
