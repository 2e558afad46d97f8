// Internal to the importers: the import of one file, with what every reader must get right: undoing everything on
// failure, warnings, cancellation, units, and geometry that could not be committed.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "sightline/importers/import.h"
#include "sightline/importers/internal/mesh_sharing.h"
#include "sightline/importers/internal/polygon_mesh.h"

namespace sightline::importers {

/// Thrown below run_import() where a file cannot be read on; run_import() returns the error.
struct ImportFault {
  core::Error error;
};
/// The value of a result; throws its error.
template <class T>
T value_or_throw(core::Expected<T> result) {
  if (!result) throw ImportFault{std::move(result.error())};
  if constexpr (!std::is_void_v<T>) return std::move(*result);
}

/// What a format's coordinates mean. With UpAxis::kAutomatic the meshes decide in the end, unless the file says it.
struct FileFrame {
  double metres_per_unit = 1.0;
  UpAxis up = UpAxis::kZ;
};

class ImportJob {
 public:
  core::Scene& scene() { return scene_; }
  const ImportOptions& options() const { return options_; }
  const std::string& file() const { return file_; }      ///< its name, for messages
  core::NodeId file_node() const { return file_node_; }  ///< named after the file; its transform is the file's frame
  ImportReport& report() { return report_; }

  void warn(std::uint64_t offset, std::string message);
  /// An error "FILE: message" when strict, a warning when lenient.
  core::Expected<void> damage(std::uint64_t offset, std::string message);
  /// The file says itself which axis points up; counts where the caller does not say it.
  void state_up(UpAxis up);
  /// Fails when the caller cancels. Cheap enough to be called for every chunk of a file.
  core::Expected<void> progress(double share);

  /// Adds an item, counts it as kind `found`, and shares its mesh where an equal one is known. `node` is the file's
  /// node or below it. A mesh that the scene refuses is damage: it is left out, the call returns false, and a strict
  /// import fails.
  bool add_mesh(core::NodeId node, core::Mesh mesh, const core::Affine& placement, core::MaterialId material = {},
                core::Kind found = core::Kind::kMesh);
  /// Adds polygons as files hold them: re-centred, cleaned and triangulated (polygon_mesh.h). Dropped faces
  /// become a warning at `offset`.
  bool add_mesh(core::NodeId node, const PolygonMesh& polygons, std::string_view name, const core::Affine& placement,
                core::MaterialId material, std::uint64_t offset = 0);
  /// Adds another item of a mesh that is in the scene already. `first`: no item uses the mesh yet.
  void add_instance(core::NodeId node, core::MeshId mesh, const core::Affine& placement, core::MaterialId material = {},
                    bool first = false);
  /// Adds an item and counts it.
  void add_primitive(core::NodeId node, const core::Primitive& primitive, const core::Affine& placement,
                     core::MaterialId material = {});

  /// Promises that no item, as placed below the file's node, reaches farther than kLargestCoordinate. This saves a
  /// check of each item at the end.
  void promise_reach() { reach_promised_ = true; }

 private:
  friend core::Expected<ImportReport> run_import(std::string_view, core::Scene&, core::NodeId, const ImportOptions&,
                                                 const FileFrame&,
                                                 const std::function<core::Expected<void>(ImportJob&)>&);
  ImportJob(std::string_view file, core::Scene& scene, core::NodeId parent, const ImportOptions& options,
            const FileFrame& frame);
  void turn_if_y_seems_up();
  void drop_what_cannot_be_committed(core::ItemId first);
  void say_if_nothing_is_drawn();
  core::Expected<void> finish(core::ItemId first);

  core::Scene& scene_;
  const ImportOptions& options_;
  std::string file_;
  FileFrame frame_;
  core::NodeId file_node_;
  MeshSharing sharing_;
  ImportReport report_;
  core::Expected<void> refused_;  // error of a strict import, returned by the next progress() or at the end
  std::uint64_t unlisted_ = 0;
  double shown_ = -1.0;
  bool reach_promised_ = false;
};

/// Runs `read` for a file named `file`. When it fails, or when something below it throws (out of memory, a library),
/// the scene is as it was.
core::Expected<ImportReport> run_import(std::string_view file, core::Scene& scene, core::NodeId parent,
                                        const ImportOptions& options, const FileFrame& frame,
                                        const std::function<core::Expected<void>(ImportJob&)>& read);

/// An import whose error names the file as the caller did, not by its last part alone.
core::Expected<ImportReport> with_whole_path(core::Expected<ImportReport> report, const std::filesystem::path& path);

/// The frame of a format that states nothing about its coordinates.
inline FileFrame frame_of(const ImportOptions& options) {
  return {options.metres_per_unit, options.up};
}
/// The frame of a format that has z up by custom.
inline FileFrame frame_with_z_up(const ImportOptions& options) {
  return {options.metres_per_unit, options.up == UpAxis::kAutomatic ? UpAxis::kZ : options.up};
}

}  // namespace sightline::importers
