// Writes a scene as a scene cache (.slc, docs/guide/scene-cache.md): what a second start needs, so that it neither
// parses nor sorts. import_file() reads it.
#pragma once

#include <filesystem>
#include <functional>

#include "sightline/core/api.h"
#include "sightline/core/error.h"
#include "sightline/core/scene.h"
#include "sightline/importers/import.h"

namespace sightline::importers {

/// Writes everything below the root: nodes with names and attributes, items, meshes, materials, and the snapshot of
/// that. Reading gives the same ids. A root that is moved, hidden, or has layers or a material of its own gives these
/// to its children. Pending edits are written, too; commit() must be able to accept them.
///
/// Writes a temporary file beside `path` and renames it at the end: on failure the old file stays. `report`, if any, is
/// what reading will report; its nodes are not kept. Fails on a path that cannot be written, and when the root holds
/// items itself. `progress` works as ImportOptions::progress.
SIGHTLINE_API core::Expected<void> write_slc(const core::Scene& scene, const std::filesystem::path& path,
                                             const ImportReport* report = nullptr,
                                             const std::function<bool(double)>& progress = {});

}  // namespace sightline::importers
