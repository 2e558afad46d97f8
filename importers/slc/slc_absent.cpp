// Scene caches in a build without them.
#include <fmt/format.h>

#include "sightline/importers/internal/scene_cache.h"
#include "sightline/importers/slc/paged_scene.h"
#include "sightline/importers/slc/slc_writer.h"

namespace sightline::importers {

core::Expected<void> write_slc(const core::Scene&, const std::filesystem::path& path, const SlcWriteOptions&) {
  return core::fail(fmt::format("{}: this build writes no .slc files (SIGHTLINE_SLC is off)", path.string()));
}

core::Expected<std::vector<std::filesystem::path>> scene_caches_of(const std::filesystem::path& path) {
  return std::vector<std::filesystem::path>{path};
}

core::Expected<core::PagedScene> open_paged_scene(const std::filesystem::path& path,
                                                  const std::function<bool(double)>&) {
  return core::fail(fmt::format("{}: this build reads no .slc files (SIGHTLINE_SLC is off)", path.string()));
}

core::Expected<ImportReport> import_with_cache(std::span<const std::filesystem::path> paths, core::Scene& scene,
                                               core::NodeId parent, const ImportOptions& options) {
  auto report = read_files(paths, scene, parent, options);
  if (report)
    report->warnings.push_back(
        {options.cache_folder.string(), 0, "not used: this build has no scene cache (SIGHTLINE_SLC is off)"});
  return report;
}

}  // namespace sightline::importers
