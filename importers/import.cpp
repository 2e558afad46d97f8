#include "sightline/importers/import.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <string_view>
#include <system_error>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sightline/importers/file_bytes.h"
#include "sightline/importers/rvm/rvm_attributes.h"
#ifdef SIGHTLINE_HAVE_GLTF
#include "sightline/importers/gltf/gltf_reader.h"
#endif
#include "sightline/importers/ply/ply_reader.h"
#include "sightline/importers/rvm/rvm_reader.h"
#include "sightline/importers/stl/stl_reader.h"
#ifdef SIGHTLINE_HAVE_OBJ
#include "sightline/importers/obj/obj_reader.h"
#endif

namespace sightline::importers {
namespace {

using Bytes = std::span<const std::byte>;

struct Format {
  std::string_view extension;
  core::Expected<ImportReport> (*read)(Bytes, const std::filesystem::path&, core::Scene&, core::NodeId,
                                       const ImportOptions&);
};

constexpr Format kFormats[] = {
    {".rvm",
     [](Bytes bytes, const std::filesystem::path& path, core::Scene& scene, core::NodeId parent,
        const ImportOptions& options) { return read_rvm(bytes, path.filename().string(), scene, parent, options); }},
    {".txt", read_rvm_attributes},
    {".att", read_rvm_attributes},
    {".ply", read_ply},
    {".stl", read_stl},
#ifdef SIGHTLINE_HAVE_OBJ
    {".obj", read_obj},
#endif
#ifdef SIGHTLINE_HAVE_GLTF
    {".gltf", read_gltf},
    {".glb", read_gltf},
#endif
};

/// Formats that a build may lack, and the option that it then lacks.
struct Optional {
  std::string_view extension, option;
};
constexpr Optional kOptional[] = {{".obj", "SIGHTLINE_OBJ"}, {".gltf", "SIGHTLINE_GLTF"}, {".glb", "SIGHTLINE_GLTF"}};

constexpr auto kExtensions = [] {
  std::array<std::string_view, std::size(kFormats)> all;
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = kFormats[i].extension;
  return all;
}();

std::string lower_case_extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension)
    if (c >= 'A' && c <= 'Z') c = char(c - 'A' + 'a');
  return extension;
}

bool is_attribute_file(const std::filesystem::path& path) {
  const std::string extension = lower_case_extension(path);
  return extension == ".txt" || extension == ".att";
}

core::Expected<ImportReport> read_by_extension(const std::filesystem::path& path, core::Scene& scene,
                                               core::NodeId parent, const ImportOptions& options) {
  const std::string extension = lower_case_extension(path);
  const auto* format =
      std::find_if(std::begin(kFormats), std::end(kFormats), [&](const Format& f) { return f.extension == extension; });
  if (format == std::end(kFormats)) {
    for (const Optional& o : kOptional)
      if (o.extension == extension)
        return core::fail(
            fmt::format("{}: this build reads no {} files ({} is off)", path.string(), extension, o.option));
    return core::fail(fmt::format("{}: unknown extension '{}', expected {}", path.string(), path.extension().string(),
                                  fmt::join(kExtensions, ", ")));
  }
  const auto bytes = read_file_bytes(path);
  if (!bytes) return tl::unexpected(bytes.error());
  auto report = format->read(*bytes, path, scene, parent, options);
  if (!report && report.error().message != kCancelled && path.has_parent_path())
    report.error().message = (path.parent_path() / report.error().message).string();
  return report;
}

void append(ImportReport& total, ImportReport&& one) {
  total.nodes.insert(total.nodes.end(), one.nodes.begin(), one.nodes.end());
  std::move(one.warnings.begin(), one.warnings.end(), std::back_inserter(total.warnings));
  for (std::size_t k = 0; k < total.items.size(); ++k) total.items[k] += one.items[k];
  total.degenerate += one.degenerate;
  total.attributed += one.attributed;
  total.shared_meshes += one.shared_meshes;
  total.sharing_error = std::max(total.sharing_error, one.sharing_error);
  total.bytes += one.bytes;
  if (!one.nodes.empty()) total.metres_per_unit = one.metres_per_unit;
}

}  // namespace

std::span<const std::string_view> known_extensions() {
  return kExtensions;
}

core::Expected<ImportReport> import_file(const std::filesystem::path& path, core::Scene& scene, core::NodeId parent,
                                         const ImportOptions& options) {
  std::error_code ignored;
  const auto status = std::filesystem::status(path, ignored);
  if (!std::filesystem::exists(status)) return core::fail(fmt::format("{}: no such file", path.string()));
  if (std::filesystem::is_directory(status))
    return core::fail(fmt::format("{}: is a directory, expected a model file", path.string()));
  if (!std::filesystem::is_regular_file(status))
    return core::fail(fmt::format("{}: not a regular file", path.string()));
  return read_by_extension(path, scene, parent, options);
}

core::Expected<ImportReport> import_files(std::span<const std::filesystem::path> paths, core::Scene& scene,
                                          core::NodeId parent, const ImportOptions& options) {
  std::vector<std::filesystem::path> ordered(paths.begin(), paths.end());
  std::stable_partition(ordered.begin(), ordered.end(), [](const auto& path) { return !is_attribute_file(path); });
  const core::Scene::Mark mark = scene.mark();
  ImportReport total;
  for (std::size_t i = 0; i < ordered.size(); ++i) {
    ImportOptions one = options;
    if (options.progress)
      one.progress = [&, i](double share) { return options.progress((double(i) + share) / double(ordered.size())); };
    auto report = import_file(ordered[i], scene, parent, one);
    if (!report) {
      scene.take_back(mark, total.nodes);
      return report;
    }
    append(total, std::move(*report));
  }
  return total;
}

}  // namespace sightline::importers
