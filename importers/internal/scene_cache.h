// Imports that keep scene caches in a folder. Internal to the importers.
#pragma once

#include <filesystem>
#include <span>

#include "sightline/importers/import.h"

namespace sightline::importers {

/// import_files() without a cache.
core::Expected<ImportReport> read_files(std::span<const std::filesystem::path> paths, core::Scene& scene,
                                        core::NodeId parent, const ImportOptions& options);

/// import_files() with ImportOptions::cache_folder.
core::Expected<ImportReport> import_with_cache(std::span<const std::filesystem::path> paths, core::Scene& scene,
                                               core::NodeId parent, const ImportOptions& options);

}  // namespace sightline::importers
