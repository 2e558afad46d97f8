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

struct SlcWriteOptions {
  /// What reading will report, but for nodes; null: what the scene tells.
  const ImportReport* report = nullptr;
  /// Builds levels of detail (docs/guide/levels-of-detail.md) of meshes that came without, so that no start need: about
  /// 3 us a triangle on a core, and some 10 bytes. Levels that meshes came with are written in any case.
  bool levels = false;
  /// As ImportOptions::progress.
  std::function<bool(double)> progress = {};
};

/// Writes everything below the root: nodes with names and attributes, items, meshes, materials, and the snapshot of
/// that. Reading gives the same ids. A root that is moved, hidden, or has layers or a material of its own gives these
/// to its children. Pending edits are written, too; commit() must be able to accept them.
///
/// Writes a temporary file beside `path` and renames it at the end: on failure the old file stays. Fails on a path that
/// cannot be written, when the root holds items itself, and where levels are to be built by a library that builds none.
SIGHTLINE_API core::Expected<void> write_slc(const core::Scene& scene, const std::filesystem::path& path,
                                             const SlcWriteOptions& options = {});

}  // namespace sightline::importers
