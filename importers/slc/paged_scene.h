// Opens scene caches (.slc, docs/guide/scene-cache.md) as scenes whose items are read page by page.
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "sightline/core/api.h"
#include "sightline/core/error.h"
#include "sightline/core/paged_scene.h"

namespace sightline::importers {

/// The files that stand for a model: all *.slc of a folder, in the order of their names; else the path itself. Fails on
/// a folder that cannot be read or has none.
SIGHTLINE_API core::Expected<std::vector<std::filesystem::path>> scene_caches_of(const std::filesystem::path& path);

/// Opens scene_caches_of(path) as parts of one scene: item i of a part has the id i + item slots of the parts before.
/// Reads and verifies what stays in memory, not the pages. Files must not be changed in place while the result or a
/// copy of its loader lives; replacing them by renaming is safe.
///
/// Files stay open, each with a descriptor. Fails on a file that cannot be read, that is damaged or of another version,
/// and on a folder without such files. Only builds with SIGHTLINE_SLC have it; others fail. `progress` works as
/// ImportOptions::progress.
SIGHTLINE_API core::Expected<core::PagedScene> open_paged_scene(const std::filesystem::path& path,
                                                                const std::function<bool(double)>& progress = {});

}  // namespace sightline::importers
