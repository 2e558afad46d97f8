// Import with progress, cancellation and Ctrl-C; writing files.
#include <array>
#include <numeric>
#include <optional>
#include <span>

#include "sightline/bindings/python/config.h"
#include "sightline/bindings/python/module.h"
#include "sightline/bindings/python/progress.h"
#include "sightline/bindings/python/scene.h"
#include "sightline/bindings/python/setting_values.h"
#include "sightline/engine/internal/settings.h"
#include "sightline/importers/import.h"
#include "sightline/importers/internal/settings.h"
#include "sightline/importers/write_file.h"

namespace sightline::engine {

#define SIGHTLINE_CHOICE SIGHTLINE_NAME_CHOICE
#include "sightline/importers/internal/settings.inc"

}  // namespace sightline::engine

namespace sightline::python {
namespace {

struct Imported {
  ScenePtr scene;
  importers::ImportReport report;
};

using importers::ImportOptions, importers::WriteOptions;
using importers::kAboveZero, importers::kAnyFinite, importers::kMostInt, importers::kPi;

/// A row of settings of imports, or of files that are written.
#define SIGHTLINE_OPTION(Options, name, type, low, high, range, help)            \
  {#name,                                                                        \
   help,                                                                         \
   range,                                                                        \
   true,                                                                         \
   false,                                                                        \
   std::string_view(#type) != "path",                                            \
   [](const Options& options) { return get(options.name); },                     \
   [](Options& options, const char* argument, py::handle value) {                \
     if (value.is_none() && std::string_view(#type) == "path") return;           \
     set(options.name, argument, value);                                         \
     if (!engine::check_range({#name, low, high, range}, options.name))          \
       fail(#name ": expected " range ", found " + std::string(py::str(value))); \
   }},

constexpr Setting<ImportOptions> kImportSettings[] = {
#define SIGHTLINE_SETTING(path, name, type, change, low, high, range, initial, help) \
  SIGHTLINE_OPTION(ImportOptions, name, type, low, high, range, help)
#include "sightline/importers/internal/settings.inc"
};
constexpr Setting<WriteOptions> kWriteSettings[] = {
#define SIGHTLINE_WRITE_SETTING(path, name, type, change, low, high, range, initial, help) \
  SIGHTLINE_OPTION(WriteOptions, name, type, low, high, range, help)
#include "sightline/importers/internal/settings.inc"
};

}  // namespace

template <>
std::span<const Setting<ImportOptions>> settings() {
  return kImportSettings;
}
template <>
std::span<const Setting<WriteOptions>> settings() {
  return kWriteSettings;
}

namespace {

Imported run(const ScenePtr& scene, const std::optional<Node>& parent, importers::ImportOptions options,
             const py::object& callback, const std::vector<std::filesystem::path>& paths) {
  Progress progress(callback);
  options.progress = progress.function();
  const core::NodeId below = node_in(scene, parent, "parent");
  core::Expected<importers::ImportReport> report;
  {
    const LongCall call({scene->gate, Use::kWrite});
    if (!scene->scene.contains(below)) fail("parent: it has been removed from its scene");
    report = importers::import_files(paths, scene->scene, below, options);
  }
  progress.rethrow();
  return {scene, unwrap(std::move(report))};
}

py::dict write_scene(const ScenePtr& scene, const std::filesystem::path& path, const std::optional<Node>& node,
                     const py::object& callback, const py::kwargs& given) {
  WriteOptions options = config_of<WriteOptions>("write", given);
  Progress progress(callback);
  options.progress = progress.function();
  const core::NodeId top = node_in(scene, node, "node");
  core::Expected<importers::WriteReport> done;
  {
    const LongCall call({scene->gate, Use::kRead});
    if (!scene->scene.contains(top)) fail("node: it has been removed from its scene");
    done = importers::write_file(scene->scene, top, path, options);
  }
  progress.rethrow();
  const importers::WriteReport report = unwrap(std::move(done));
  const auto triangles = report.triangles.value_or(importers::WriteReport::Tessellated());
  using namespace py::literals;
  return py::dict("items"_a = std::accumulate(report.items.begin(), report.items.end(), std::uint64_t(0)),
                  "left_out"_a = report.left_out, "bytes"_a = report.bytes, "triangles"_a = triangles.triangles,
                  "largest_chord_error"_a = triangles.largest_chord_error);
}

/// A dict from names of an enumeration to counts.
template <class Name, std::size_t N>
py::dict counts_by_name(const std::array<std::uint64_t, N>& counts) {
  py::dict named;
  for (std::size_t i = 0; i < N; ++i) named[py::str(std::string(name_of(Name(i))))] = counts[i];
  return named;
}

void bind_recognition(py::module_& m) {
  using Report = importers::RecognitionReport;
  py::class_<Report> c(m, "Recognition",
                       "Primitives recognised in meshes, which count once, however many items share them.");
  c.def_readonly("meshes", &Report::meshes, "Looked at.")
      .def_property_readonly(
          "items", [](const Report& r) { return counts_by_name<core::Kind>(r.items); },
          "Items of primitives made, by kind, a dict.")
      .def_readonly("triangles_before", &Report::triangles_before, "Of the meshes.")
      .def_readonly("triangles_after", &Report::triangles_after, "Of what is left of them.")
      .def_readonly("bytes_before", &Report::bytes_before, "Of vertices, normals and indices.")
      .def_readonly("bytes_after", &Report::bytes_after, "Of what is left of them, and of parameters.")
      .def_readonly("largest_deviation", &Report::largest_deviation,
                    "Metres between triangles and the surfaces that replace them, both ways, in the scene.")
      .def_property_readonly(
          "refused", [](const Report& r) { return counts_by_name<importers::Refusal>(r.refused); },
          "Solids that stayed triangles, in part or wholly, by reason, a dict.");
  bind_value<&Report::meshes, &Report::items, &Report::triangles_before, &Report::triangles_after,
             &Report::bytes_before, &Report::bytes_after, &Report::largest_deviation, &Report::refused>(c);
}

void bind_surfaces(py::module_& m) {
  using Report = importers::ExactSurfaceReport;
  py::class_<Report> c(m, "ExactSurfaces",
                       "What became of STEP, IGES and BREP. Parts count once, however often they are used.");
  c.def_readonly("parts", &Report::parts, "With a shape.")
      .def_readonly("instances", &Report::instances, "Uses of them.")
      .def_readonly("analytic_solids", &Report::analytic_solids, "That became primitives.")
      .def_readonly("meshed_bodies", &Report::meshed_bodies, "Other solids, shells and loose faces.")
      .def_readonly("triangles", &Report::triangles, "Of these.")
      .def_readonly("failed_faces", &Report::failed_faces, "That could not be meshed.")
      .def_readonly("curves", &Report::curves, "Not read.")
      .def_readonly("annotations", &Report::annotations, "Dimensions, tolerances and notes, not read.")
      .def_readonly("largest_tolerance", &Report::largest_tolerance, "Of any part, metres.")
      .def_readonly("deviation", &Report::deviation, "Metres: the largest found between triangles and surfaces.")
      .def_readonly("analytic_deviation", &Report::analytic_deviation,
                    "Metres: no primitive lies farther from its solid's surfaces.");
  bind_value<&Report::parts, &Report::instances, &Report::analytic_solids, &Report::meshed_bodies, &Report::triangles,
             &Report::failed_faces, &Report::curves, &Report::annotations, &Report::largest_tolerance,
             &Report::deviation, &Report::analytic_deviation>(c);
}

void bind_report(py::module_& m) {
  using importers::ImportWarning;
  py::class_<ImportWarning> warning(m, "ImportWarning", "Something that a reader noticed and went on.");
  warning
      .def_property_readonly(
          "file", [](const ImportWarning& w) { return to_text(w.file); }, "Its name.")
      .def_readonly("offset", &ImportWarning::offset, "Bytes from the file's begin.")
      .def_property_readonly(
          "message", [](const ImportWarning& w) { return to_text(w.message); }, "One line.");
  bind_value<&ImportWarning::file, &ImportWarning::offset, &ImportWarning::message>(warning);
  bind_recognition(m);
  bind_surfaces(m);
  py::class_<Imported>(m, "ImportReport", "What an import brought.")
      .def_property_readonly(
          "nodes",
          [](const Imported& r) {
            std::vector<Node> nodes;
            for (const core::NodeId id : r.report.nodes) nodes.push_back({r.scene, id});
            return nodes;
          },
          "A node for each model file.")
      .def_property_readonly(
          "warnings", [](const Imported& r) { return r.report.warnings; }, "What was noticed, at most 1,001.")
      .def_property_readonly(
          "items", [](const Imported& r) { return counts_by_name<core::Kind>(r.report.items); },
          "Items by kind, a dict.")
      .def_property_readonly(
          "degenerate", [](const Imported& r) { return r.report.degenerate; }, "Items without volume, length or area.")
      .def_property_readonly(
          "shared_meshes", [](const Imported& r) { return r.report.shared_meshes; },
          "Items that use a mesh which another item brought.")
      .def_property_readonly(
          "attributed", [](const Imported& r) { return r.report.attributed; },
          "Groups that an attribute file gave attributes to.")
      .def_property_readonly(
          "sharing_error", [](const Imported& r) { return r.report.sharing_error; },
          "Metres that a vertex of a shared mesh lies off, at most.")
      .def_property_readonly(
          "bytes", [](const Imported& r) { return r.report.bytes; }, "Read from files.")
      .def_property_readonly(
          "from_cache", [](const Imported& r) { return r.report.from_cache; },
          "Whether a scene cache was read instead of the files.")
      .def_property_readonly(
          "recognition", [](const Imported& r) { return r.report.recognition; }, "What `recognise` did.")
      .def_property_readonly(
          "surfaces", [](const Imported& r) { return r.report.surfaces; }, "Of STEP, IGES and BREP.")
      .def_property_readonly(
          "metres_per_unit", [](const Imported& r) { return r.report.metres_per_unit; },
          "Of the last file's coordinates.");
}

}  // namespace

void bind_import(py::module_& m, SceneClass& scene) {
  bind_report(m);
  const std::string words =
      "A failed or cancelled import leaves the scene as it was.\n\n"
      "progress: called with the share done, 0 to 1; False cancels, and so do exceptions and Ctrl-C.";
  const auto doc = [&](const char* function, const char* what, const std::string& does) {
    return doc_of<ImportOptions>(function, std::string(what) + ": object, parent: object = None",
                                 "progress: object = None", does + words, false, "ImportReport");
  };
  const std::string file_doc =
      doc("import_file", "path", "Imports a model file of any known format below `parent`, or the root. ");
  const std::string files_doc =
      doc("import_files", "paths", "Imports several files, a node each, side by side; all or none. ");
  using namespace py::literals;
  py::options options;
  options.disable_function_signatures();
  scene.def(
      "import_file",
      [](const ScenePtr& s, const std::filesystem::path& path, const std::optional<Node>& parent,
         const py::object& progress, const py::kwargs& given) {
        return run(s, parent, config_of<ImportOptions>("import_file", given), progress, {path});
      },
      "path"_a, "parent"_a = py::none(), py::kw_only(), "progress"_a = py::none(), file_doc.c_str());
  scene.def(
      "import_files",
      [](const ScenePtr& s, const std::vector<std::filesystem::path>& paths, const std::optional<Node>& parent,
         const py::object& progress, const py::kwargs& given) {
        return run(s, parent, config_of<ImportOptions>("import_files", given), progress, paths);
      },
      "paths"_a, "parent"_a = py::none(), py::kw_only(), "progress"_a = py::none(), files_doc.c_str());
  const std::string write_doc = doc_of<WriteOptions>(
      "write", "path: object, node: object = None", "progress: object = None",
      "Writes what is below a node, or the root, in the format that the name ends in: .rvm, .obj, .glb, .gltf, .stl, .ply, or .slc "
      "for a cache of the whole scene. Returns a dict: items, left_out, bytes, triangles that stand for primitives, "
      "and "
      "their largest_chord_error in metres. `progress` as in import_file().",
      false, "dict");
  scene.def("write", &write_scene, "path"_a, "node"_a = py::none(), py::kw_only(), "progress"_a = py::none(),
            write_doc.c_str());
  options.enable_function_signatures();
  m.def(
      "known_extensions",
      [] {
        std::vector<std::string> names;
        for (const std::string_view name : importers::known_extensions()) names.emplace_back(name);
        return names;
      },
      "Extensions that import_file() knows, with dots.");
}

}  // namespace sightline::python
