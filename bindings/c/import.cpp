#include <numbers>

#include "sightline/bindings/c/internal/objects.h"
#include "sightline/bindings/c/internal/values.h"
#if SIGHTLINE_HAS_IMPORTERS
#include "sightline/importers/import.h"
#endif

using namespace sightline;
using namespace sightline::capi;

#if SIGHTLINE_HAS_IMPORTERS
namespace {

importers::ImportOptions options_of(const sl_import_options& from) {
  importers::ImportOptions options;
  options.lenient = from.lenient != 0;
  require(from.metres_per_unit > 0.0 && std::isfinite(from.metres_per_unit), "metres_per_unit above 0");
  options.metres_per_unit = from.metres_per_unit;
  options.up = enum_of<importers::UpAxis>(from.up, 3, "up");
  options.copies = enum_of<importers::MeshCopies>(from.copies, 3, "copies");
  options.threads = from.threads;
  if (from.cache_folder) options.cache_folder = path_of(from.cache_folder);
  options.recognise = from.recognise != 0;
  require(from.recognise_tolerance >= 0.0 && std::isfinite(from.recognise_tolerance),
          "recognise_tolerance of 0 or more");
  options.recognise_tolerance = from.recognise_tolerance;
  require(from.crease_angle >= 0.0 && from.crease_angle <= std::numbers::pi, "a crease_angle from 0 to pi");
  options.crease_angle = from.crease_angle;
  require(from.chord_tolerance >= 0.0 && std::isfinite(from.chord_tolerance), "chord_tolerance of 0 or more");
  options.chord_tolerance = from.chord_tolerance;
  require(from.chord_angle > 0.0 && from.chord_angle <= std::numbers::pi, "a chord_angle above 0, to pi");
  options.chord_angle = from.chord_angle;
  options.in_process = from.in_process != 0;
  options.cached_levels = from.cached_levels != 0;
  options.progress = progress_of(from.progress, from.user);
  return options;
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
      auto imported = importers::import_files(files, *scene, scene.id(parent), translated);
      if (!imported && imported.error().message == importers::kCancelled)
        throw Failure{SL_ERROR_CANCELLED, std::move(imported.error().message)};
      return value_of(std::move(imported));
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
