// Scenes in and out of the container of a scene cache. Internal to the importers.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "sightline/core/paged_scene.h"
#include "sightline/importers/import.h"
#include "sightline/importers/slc/internal/slc_file.h"
#include "sightline/importers/slc/slc_writer.h"

namespace sightline::importers {

/// write_slc() with what the content was read from (scene_cache.cpp), as text; empty: unknown.
core::Expected<void> write_slc(const core::Scene& scene, const std::filesystem::path& path,
                               const SlcWriteOptions& options, std::string_view sources);

struct SlcScene {
  core::Scene scene;  ///< nothing is committed
  ImportReport report;
  bool has_levels = false;  ///< of detail: all meshes came with theirs, as far as they have any
};
/// All of it. `verified`: checksums are compared; without, only what memory safety needs is checked.
SlcExpected<SlcScene> load(std::shared_ptr<const SlcFile> file, bool verified = true);

/// Makes the snapshot in the file that of the scene, which must be what the file was written from.
SlcExpected<void> attach_snapshot(std::shared_ptr<const SlcFile> file, core::Scene& scene, bool verified = true);

/// Adds the materials in the file to an empty scene. They must be verified.
SlcExpected<void> read_materials(const SlcFile& file, const SlcFile::Mapping& mapping, core::Scene& scene);

/// open_paged_scene() of one file. `verified`: as load(). `name` stands for the file.
core::Expected<core::PagedScene> open_paged_scene(std::shared_ptr<const SlcFile> file,
                                                  const std::filesystem::path& name, bool verified = true);

/// Whether what lies below the node lies where its own transforms say.
bool is_unmoved(const core::Scene& scene, core::NodeId node);

/// The text of kSlcSources, verified.
SlcExpected<std::string> sources_of(const SlcFile& file);

/// The reader of import_file().
core::Expected<ImportReport> read_slc(const std::filesystem::path& path, core::Scene& scene, core::NodeId parent,
                                      const ImportOptions& options);
/// Reads bytes in memory, for tests and the fuzzer. `name` stands for the file.
core::Expected<ImportReport> read_slc(std::span<const std::byte> bytes, const std::filesystem::path& name,
                                      core::Scene& scene, core::NodeId parent, const ImportOptions& options);

}  // namespace sightline::importers
