#include "sightline/importers/import.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <new>
#include <string_view>
#include <system_error>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sightline/importers/internal/file_bytes.h"
#include "sightline/importers/rvm/internal/rvm_attributes.h"
#ifdef SIGHTLINE_HAVE_GLTF
#include "sightline/importers/gltf/internal/gltf_reader.h"
#endif
#include "sightline/importers/internal/extension.h"
#include "sightline/importers/internal/import_job.h"
#include "sightline/importers/internal/side_files.h"
#include "sightline/importers/obj/internal/obj_reader.h"
#include "sightline/importers/ply/internal/ply_reader.h"
#include "sightline/importers/recognise/internal/recognise.h"
#include "sightline/importers/rvm/internal/rvm_reader.h"
#include "sightline/importers/stl/internal/stl_reader.h"
#ifdef SIGHTLINE_HAVE_SLC
#include "sightline/importers/slc/internal/slc_scene.h"
#endif
#ifdef SIGHTLINE_HAVE_VTK
#include "sightline/importers/vtk/internal/vtk_module.h"
#endif
#ifdef SIGHTLINE_HAVE_OCCT
#include "sightline/importers/cad/internal/cad_import.h"
#endif

namespace sightline::importers {
namespace {

using Bytes = std::span<const std::byte>;

using Report = core::Expected<ImportReport>;

struct Format {
  std::string_view extension;
  Report (*read)(Bytes, const std::filesystem::path&, core::Scene&, core::NodeId, const ImportOptions&) = nullptr;
  /// For formats that are not read as a whole by us.
  Report (*open)(const std::filesystem::path&, core::Scene&, core::NodeId, const ImportOptions&) = nullptr;
};

core::Expected<ImportReport> read_rvm_file(Bytes bytes, const std::filesystem::path& path, core::Scene& scene,
                                           core::NodeId parent, const ImportOptions& options) {
  return read_rvm(bytes, path.filename().string(), scene, parent, options);
}

constexpr Format kFormats[] = {
    {".rvm", read_rvm_file},
    {".rev", read_rvm_file},
    {".txt", read_rvm_attributes},
    {".att", read_rvm_attributes},
    {".obj", read_obj},
    {".ply", read_ply},
    {".stl", read_stl},
#ifdef SIGHTLINE_HAVE_SLC
    {".slc", nullptr, read_slc},
#endif
#ifdef SIGHTLINE_HAVE_GLTF
    {".gltf", read_gltf},
    {".glb", read_gltf},
#endif
#ifdef SIGHTLINE_HAVE_VTK
    {".vtk", read_vtk_by_module},
    {".vtm", read_vtk_by_module},
    {".vtmb", read_vtk_by_module},
    {".vtp", read_vtk_by_module},
    {".vtu", read_vtk_by_module},
#endif
#ifdef SIGHTLINE_HAVE_OCCT
    {".step", nullptr, import_cad},
    {".stp", nullptr, import_cad},
    {".stpz", nullptr, import_cad},
    {".iges", nullptr, import_cad},
    {".igs", nullptr, import_cad},
    {".brep", nullptr, import_cad},
#endif
};

/// Build options that a build may lack, Debian's packages that they need, and the formats that they add.
struct Optional {
  std::string_view option, packages;
  std::array<std::string_view, 6> extensions;
};
constexpr Optional kOptional[] = {{"SIGHTLINE_SLC", "libxxhash-dev", {".slc"}},
                                  {"SIGHTLINE_GLTF", "libstb-dev", {".gltf", ".glb"}},
                                  {"SIGHTLINE_VTK", "libvtk9-dev", {".vtk", ".vtm", ".vtmb", ".vtp", ".vtu"}},
                                  {"SIGHTLINE_OCCT",
                                   "libocct-data-exchange-dev and libocct-visualization-dev",
                                   {".step", ".stp", ".stpz", ".iges", ".igs", ".brep"}}};

constexpr auto kExtensions = [] {
  std::array<std::string_view, std::size(kFormats)> all;
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = kFormats[i].extension;
  return all;
}();

core::Expected<ImportReport> read_by_extension(const std::filesystem::path& path, core::Scene& scene,
                                               core::NodeId parent, const ImportOptions& options) {
  const std::string extension = lower_case_extension(path);
  const auto* format =
      std::find_if(std::begin(kFormats), std::end(kFormats), [&](const Format& f) { return f.extension == extension; });
  if (format == std::end(kFormats)) {
    for (const Optional& o : kOptional)
      if (!extension.empty() && std::find(o.extensions.begin(), o.extensions.end(), extension) != o.extensions.end())
        return core::fail(fmt::format("{}: this build reads no {} files ({}, which needs {}, is off)", path.string(),
                                      extension, o.option, o.packages));
    return core::fail(fmt::format("{}: unknown extension '{}', expected {}", path.string(), path.extension().string(),
                                  fmt::join(kExtensions, ", ")));
  }
  std::vector<std::filesystem::path> side_files;
  auto report = format->open ? format->open(path, scene, parent, options) : [&]() -> Report {
    const auto bytes = read_file_bytes(path);
    if (!bytes) return tl::unexpected(bytes.error());
    const SideFileNotes notes(side_files);
    return with_whole_path(format->read(*bytes, path, scene, parent, options), path);
  }();
  if (report && !format->open) report->side_files = std::move(side_files);
  return report;
}

/// Items by kind from `first` on.
std::array<std::uint64_t, core::kKindCount> items_from(const core::Scene& scene, core::ItemId first) {
  std::array<std::uint64_t, core::kKindCount> items{};
  for (core::ItemId item = first; to_index(item) < scene.item_slots(); ++item)
    if (scene.contains_item(item)) ++items[std::size_t(scene.kind(item))];
  return items;
}

/// Reads, and then recognises what was read. Fails, with the scene as it was, when that is cancelled.
core::Expected<ImportReport> read_and_recognise(const std::filesystem::path& path, core::Scene& scene,
                                                core::NodeId parent, const ImportOptions& options) {
  if (!(options.recognise_tolerance >= 0.0 && std::isfinite(options.recognise_tolerance)))
    return core::fail(fmt::format("{}: recognise_tolerance: expected a finite number of at least 0, found {}",
                                  path.string(), options.recognise_tolerance));
  constexpr double kReading = 0.5;  // share of the time
  const auto part = [&](double begin, double share) -> std::function<bool(double)> {
    if (!options.progress) return {};
    return [&options, begin, share](double done) { return options.progress(begin + share * done); };
  };
  const core::Scene::Mark mark = scene.mark();
  ImportOptions reading = options;
  reading.progress = part(0.0, kReading);
  auto report = read_by_extension(path, scene, parent, reading);
  if (!report) return report;
  core::Error error{std::string(kCancelled)};
  const auto before = items_from(scene, core::ItemId(mark.items));
  try {
    if (recognise_items(scene, core::ItemId(mark.items), options.recognise_tolerance, part(kReading, 1.0 - kReading),
                        report->recognition)) {
      const auto after = items_from(scene, core::ItemId(mark.items));
      for (std::size_t k = 0; k < after.size(); ++k) report->items[k] += after[k] - before[k];
      if (options.progress) (void)options.progress(1.0);
      return report;
    }
  } catch (const std::bad_alloc&) {
    error.message = fmt::format("{}: not enough memory", path.string());
  }
  scene.take_back(mark, report->nodes);
  return tl::unexpected(std::move(error));
}

}  // namespace

std::string_view name_of(Refusal refusal) {
  constexpr std::array<std::string_view, kRefusalCount> kNames = {"open", "cavity", "no structure", "off surface",
                                                                  "broken"};
  return kNames[std::size_t(refusal)];
}

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
  return options.recognise ? read_and_recognise(path, scene, parent, options)
                           : read_by_extension(path, scene, parent, options);
}

}  // namespace sightline::importers
