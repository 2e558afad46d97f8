// Reading and writing files.
#include <algorithm>
#include <numeric>

#include "sightline/bindings/c/internal/objects.h"
#include "sightline/bindings/c/internal/settings.h"
#include "sightline/bindings/c/internal/values.h"
#if SIGHTLINE_HAS_IMPORTERS
#include "sightline/importers/import.h"
#include "sightline/importers/internal/settings.h"
#include "sightline/importers/write_file.h"
#endif

using namespace sightline;
using namespace sightline::capi;

#if SIGHTLINE_HAS_IMPORTERS
namespace sightline::engine {

#define SIGHTLINE_CHOICE SIGHTLINE_NAME_CHOICE
#include "sightline/importers/internal/settings.inc"

}  // namespace sightline::engine

namespace {

using importers::kAboveZero, importers::kAnyFinite, importers::kMostInt, importers::kPi;

importers::ImportOptions options_of(const sl_import_options& from) {
  importers::ImportOptions to;
#define SIGHTLINE_SETTING(path, name, type, change, low, high, range, ...) \
  take({#name, low, high, range}, from.path, to.path);
#include "sightline/importers/internal/settings.inc"
  to.progress = progress_of(from.progress, from.user);
  return to;
}

importers::WriteOptions options_of(const sl_write_options& from) {
  importers::WriteOptions to;
#define SIGHTLINE_WRITE_SETTING(path, name, type, change, low, high, range, ...) \
  take({#name, low, high, range}, from.path, to.path);
#include "sightline/importers/internal/settings.inc"
  to.progress = progress_of(from.progress, from.user);
  return to;
}

/// The value, or a Failure that tells cancelling from other errors.
template <class T>
T finished(core::Expected<T> done) {
  if (!done && done.error().message == importers::kCancelled)
    throw Failure{SL_ERROR_CANCELLED, std::move(done.error().message)};
  return value_of(std::move(done));
}

sl_write_report report_of(const importers::WriteReport& from) {
  sl_write_report report SL_WRITE_REPORT_INIT;
  report.items = std::accumulate(from.items.begin(), from.items.end(), std::uint64_t(0));
  report.left_out = from.left_out, report.bytes = from.bytes;
  if (from.triangles) {
    report.triangles = from.triangles->triangles;
    report.largest_chord_error = from.triangles->largest_chord_error;
  }
  return report;
}

sl_import_report report_of(const importers::ImportReport& from) {
  sl_import_report report SL_IMPORT_REPORT_INIT;
  report.node_count = std::uint32_t(from.nodes.size());
  std::copy(from.items.begin(), from.items.end(), report.items);
  report.degenerate = from.degenerate;
  report.shared_meshes = from.shared_meshes;
  report.attributed = from.attributed;
  report.bytes = from.bytes;
  report.warnings = from.warnings.size();
  report.sharing_error = from.sharing_error;
  report.metres_per_unit = from.metres_per_unit;
  report.from_cache = from.from_cache;
  const importers::RecognitionReport& recognition = from.recognition;
  std::copy(recognition.items.begin(), recognition.items.end(), report.recognised);
  report.meshes_examined = recognition.meshes;
  report.triangles_before = recognition.triangles_before, report.triangles_after = recognition.triangles_after;
  report.mesh_bytes_before = recognition.bytes_before, report.mesh_bytes_after = recognition.bytes_after;
  report.largest_deviation = recognition.largest_deviation;
  static_assert(importers::kRefusalCount == SL_REFUSED_COUNT);
  std::copy(recognition.refused.begin(), recognition.refused.end(), report.refused);
  const importers::ExactSurfaceReport& surfaces = from.surfaces;
  report.parts = surfaces.parts, report.instances = surfaces.instances;
  report.analytic_solids = surfaces.analytic_solids, report.meshed_bodies = surfaces.meshed_bodies;
  report.surface_triangles = surfaces.triangles, report.failed_faces = surfaces.failed_faces;
  report.curves = surfaces.curves, report.annotations = surfaces.annotations;
  report.largest_chord_tolerance = surfaces.largest_tolerance;
  report.surface_deviation = surfaces.deviation, report.analytic_deviation = surfaces.analytic_deviation;
  return report;
}

void tell(const importers::ImportReport& report, const sl_import_options& options) {
  if (!options.warning) return;
  for (const importers::ImportWarning& warning : report.warnings)
    options.warning(warning.file.c_str(), warning.offset, warning.message.c_str(), options.user);
}

}  // namespace
#endif

sl_status sl_import(sl_scene handle, sl_node parent, const char* const* paths, size_t path_count,
                    const sl_import_options* options, sl_node* nodes, sl_import_report* report) {
  return call(__func__, [&] {
#if SIGHTLINE_HAS_IMPORTERS
    const sl_import_options defaults = SL_IMPORT_OPTIONS_INIT;
    const sl_import_options chosen = read(options ? options : &defaults, defaults);
    const importers::ImportOptions translated = options_of(chosen);
    if (report) check_result(report);
    check_array(paths, path_count, kMostListed);
    std::vector<std::filesystem::path> files;
    for (std::size_t i = 0; i < path_count; ++i) files.push_back(path_of(paths[i]));
    const importers::ImportReport done = [&] {
      const SceneUse scene(handle, Access::kEdit);
      return finished(importers::import_files(files, *scene, scene.id(parent), translated));
    }();
    if (nodes)
      std::transform(done.nodes.begin(), done.nodes.end(), nodes, [](core::NodeId id) { return handle_of(id); });
    if (report) write(report, report_of(done));
    tell(done, chosen);
#else
    (void)handle, (void)parent, (void)paths, (void)path_count, (void)options, (void)nodes, (void)report;
    refuse(SL_ERROR_UNSUPPORTED, "this library was built without importers");
#endif
  });
}

sl_status sl_scene_write(sl_scene handle, sl_node node, const char* path, const sl_write_options* options,
                         sl_write_report* report) {
  return call(__func__, [&] {
#if SIGHTLINE_HAS_IMPORTERS
    const sl_write_options defaults = SL_WRITE_OPTIONS_INIT;
    const importers::WriteOptions translated = options_of(read(options ? options : &defaults, defaults));
    if (report) check_result(report);
    const SceneUse scene(handle, Access::kRead);
    const auto done = finished(importers::write_file(*scene, scene.id(node), path_of(path), translated));
    if (report) write(report, report_of(done));
#else
    (void)handle, (void)node, (void)path, (void)options, (void)report;
    refuse(SL_ERROR_UNSUPPORTED, "this library was built without importers");
#endif
  });
}

const char* sl_import_extensions(void) {
#if SIGHTLINE_HAS_IMPORTERS
  static const std::string all = [] {
    std::string text;
    for (const std::string_view extension : importers::known_extensions())
      text.append(text.empty() ? "" : " ").append(extension);
    return text;
  }();
  return all.c_str();
#else
  return "";
#endif
}
