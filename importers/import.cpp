#include "sightline/importers/import.h"

#include <algorithm>
#include <string_view>
#include <system_error>

#include <fmt/format.h>

#include "sightline/importers/file_bytes.h"
#include "sightline/importers/rvm_reader.h"
#ifdef SIGHTLINE_HAVE_OBJ
#include "sightline/importers/obj_reader.h"
#endif

namespace sightline::importers {
namespace {

std::string lower_case_extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension)
    if (c >= 'A' && c <= 'Z') c = char(c - 'A' + 'a');
  return extension;
}

core::Expected<ImportReport> read_by_extension(const std::filesystem::path& path, core::Scene& scene,
                                               core::NodeId parent, const ImportOptions& options) {
  const std::string extension = lower_case_extension(path);
  const bool rvm = extension == ".rvm", obj = extension == ".obj";
  if (!rvm && !obj)
    return core::fail(
        fmt::format("{}: unknown extension '{}', expected .rvm or .obj", path.string(), path.extension().string()));
#ifndef SIGHTLINE_HAVE_OBJ
  if (obj) return core::fail(fmt::format("{}: this build reads no OBJ files (SIGHTLINE_OBJ is off)", path.string()));
#endif
  const auto bytes = read_file_bytes(path);
  if (!bytes) return tl::unexpected(bytes.error());
#ifdef SIGHTLINE_HAVE_OBJ
  if (obj) return read_obj(*bytes, path, scene, parent, options);
#endif
  auto report = read_rvm(*bytes, path.filename().string(), scene, parent, options);
  if (!report && path.has_parent_path())
    report.error().message = (path.parent_path() / report.error().message).string();
  return report;
}

void append(ImportReport& total, ImportReport&& one) {
  total.nodes.insert(total.nodes.end(), one.nodes.begin(), one.nodes.end());
  std::move(one.warnings.begin(), one.warnings.end(), std::back_inserter(total.warnings));
  for (std::size_t k = 0; k < total.items.size(); ++k) total.items[k] += one.items[k];
  total.degenerate += one.degenerate;
  total.bytes += one.bytes;
  total.metres_per_unit = one.metres_per_unit;
}

}  // namespace

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
  ImportReport total;
  for (const std::filesystem::path& path : paths) {
    auto report = import_file(path, scene, parent, options);
    if (!report) {
      for (const core::NodeId node : total.nodes) scene.remove_node(node);
      return report;
    }
    append(total, std::move(*report));
  }
  return total;
}

}  // namespace sightline::importers
