// Import with progress, cancellation and Ctrl-C; writing RVM files.
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>

#include "sightline/bindings/python/module.h"
#include "sightline/bindings/python/progress.h"
#include "sightline/bindings/python/scene.h"
#include "sightline/bindings/python/values.h"
#include "sightline/importers/import.h"
#include "sightline/importers/rvm/rvm_writer.h"

namespace sightline::python {
namespace {

struct Imported {
  ScenePtr scene;
  importers::ImportReport report;
};

/// What options import_file() and import_files() share.
importers::ImportOptions options_of(bool lenient, double metres_per_unit, const std::string& up,
                                    const std::string& copies, int threads,
                                    const std::optional<std::filesystem::path>& cache, bool cached_levels,
                                    bool recognise, double recognise_tolerance, double crease_angle,
                                    double chord_tolerance, double chord_angle, bool in_process) {
  importers::ImportOptions options;
  options.lenient = lenient;
  options.metres_per_unit = metres_per_unit;
  options.up = importers::UpAxis(one_of("up", up, {"y", "z", "auto"}));
  options.copies = importers::MeshCopies(one_of("copies", copies, {"apart", "exact", "similar"}));
  if (threads < 0) fail("threads: expected 0 or more, found " + std::to_string(threads));
  options.threads = threads;
  options.cache_folder = cache.value_or("");
  options.cached_levels = cached_levels;
  options.recognise = recognise;
  if (!(recognise_tolerance >= 0.0 && std::isfinite(recognise_tolerance)))
    fail("recognise_tolerance: expected a finite number of at least 0, found " + std::to_string(recognise_tolerance));
  options.recognise_tolerance = recognise_tolerance;
  if (!(crease_angle >= 0.0 && crease_angle <= std::numbers::pi))
    fail("crease_angle: expected 0 to pi, found " + std::to_string(crease_angle));
  options.crease_angle = crease_angle;
  if (!(chord_tolerance >= 0.0 && std::isfinite(chord_tolerance)))
    fail("chord_tolerance: expected a finite number of at least 0, found " + std::to_string(chord_tolerance));
  options.chord_tolerance = chord_tolerance;
  if (!(chord_angle > 0.0 && chord_angle <= std::numbers::pi))
    fail("chord_angle: expected more than 0 and at most pi, found " + std::to_string(chord_angle));
  options.chord_angle = chord_angle;
  options.in_process = in_process;
  return options;
}

/// `import`: called with scene, parent and options, without the GIL.
template <class Import>
Imported run(const ScenePtr& scene, const std::optional<Node>& parent, importers::ImportOptions options,
             const py::object& callback, const Import& import) {
  Progress progress(callback);
  options.progress = progress.function();
  const core::NodeId below = node_in(scene, parent, "parent");
  core::Expected<importers::ImportReport> report;
  {
    const LongCall call({scene->gate, Use::kWrite});
    if (!scene->scene.contains(below)) fail("parent: it has been removed from its scene");
    report = import(scene->scene, below, options);
  }
  progress.rethrow();
  return {scene, unwrap(std::move(report))};
}

void write_rvm(const ScenePtr& scene, const std::filesystem::path& path, const std::optional<Node>& node,
               const py::object& callback) {
  Progress progress(callback);
  const core::NodeId top = node_in(scene, node, "node");
  core::Expected<void> done;
  {
    const LongCall call({scene->gate, Use::kRead});
    if (!scene->scene.contains(top)) fail("node: it has been removed from its scene");
    done = importers::write_rvm(scene->scene, top, path, progress.function());
  }
  progress.rethrow();
  unwrap(std::move(done));
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
  constexpr const char* kOptions =
      " A failed or cancelled import leaves the scene as it was. `lenient`: import what a damaged file holds. "
      "`metres_per_unit`, `up` (\"y\", \"z\" or \"auto\"): for formats that do not say. `copies` (\"apart\", "
      "\"exact\", "
      "\"similar\"): which meshes are kept once. `cache`: a folder of scene caches, so that the next import of the "
      "same unchanged files is fast. `cached_levels`: these hold levels of detail, too, which engines with `lod_error` "
      "need not build then. `recognise`: meshes become primitives where they are the triangles of some, whose vertices "
      "lie within `recognise_tolerance` metres, or, where this is 0, as near as each mesh's own tessellation tells. "
      "`crease_angle`: radians; meshes without normals look smooth but for edges bent by more; 0: facet by facet. "
      "`chord_tolerance` (metres; 0: 0.05 % of each part's diagonal) and `chord_angle` (radians): how far triangles "
      "may "
      "lie from exact surfaces of STEP, IGES and BREP, which are read in a process of their own unless `in_process`. "
      "`progress`: called with the share done, 0 to 1; False cancels, and so do exceptions and Ctrl-C.";
  static const std::string file_doc =
      std::string("Imports a model file of any known format below `parent`, or the root.") + kOptions;
  static const std::string files_doc =
      std::string("Imports several files, a node each, side by side; all or none.") + kOptions;
  using namespace py::literals;
  scene.def(
      "import_file",
      [](const ScenePtr& s, const std::filesystem::path& path, const std::optional<Node>& parent, bool lenient,
         double metres_per_unit, const std::string& up, const std::string& copies,
         const std::optional<std::filesystem::path>& cache, bool cached_levels, bool recognise,
         double recognise_tolerance, double crease_angle, double chord_tolerance, double chord_angle, bool in_process,
         const py::object& progress) {
        return run(s, parent,
                   options_of(lenient, metres_per_unit, up, copies, 0, cache, cached_levels, recognise,
                              recognise_tolerance, crease_angle, chord_tolerance, chord_angle, in_process),
                   progress, [&](core::Scene& to, core::NodeId below, const importers::ImportOptions& options) {
                     return importers::import_files(std::span(&path, 1), to, below, options);
                   });
      },
      "path"_a, "parent"_a = py::none(), py::kw_only(), "lenient"_a = false, "metres_per_unit"_a = 1.0, "up"_a = "auto",
      "copies"_a = "similar", "cache"_a = py::none(), "cached_levels"_a = false, "recognise"_a = false,
      "recognise_tolerance"_a = 0.0, "crease_angle"_a = 0.0, "chord_tolerance"_a = 0.0,
      "chord_angle"_a = importers::ImportOptions().chord_angle, "in_process"_a = false, "progress"_a = py::none(),
      file_doc.c_str());
  scene.def(
      "import_files",
      [](const ScenePtr& s, const std::vector<std::filesystem::path>& paths, const std::optional<Node>& parent,
         bool lenient, double metres_per_unit, const std::string& up, const std::string& copies, int threads,
         const std::optional<std::filesystem::path>& cache, bool cached_levels, bool recognise,
         double recognise_tolerance, double crease_angle, double chord_tolerance, double chord_angle, bool in_process,
         const py::object& progress) {
        return run(s, parent,
                   options_of(lenient, metres_per_unit, up, copies, threads, cache, cached_levels, recognise,
                              recognise_tolerance, crease_angle, chord_tolerance, chord_angle, in_process),
                   progress, [&](core::Scene& to, core::NodeId below, const importers::ImportOptions& options) {
                     return importers::import_files(paths, to, below, options);
                   });
      },
      "paths"_a, "parent"_a = py::none(), py::kw_only(), "lenient"_a = false, "metres_per_unit"_a = 1.0,
      "up"_a = "auto", "copies"_a = "similar", "threads"_a = 0, "cache"_a = py::none(), "cached_levels"_a = false,
      "recognise"_a = false, "recognise_tolerance"_a = 0.0, "crease_angle"_a = 0.0, "chord_tolerance"_a = 0.0,
      "chord_angle"_a = importers::ImportOptions().chord_angle, "in_process"_a = false, "progress"_a = py::none(),
      files_doc.c_str());
  scene.def("write_rvm", &write_rvm, "path"_a, "node"_a = py::none(), py::kw_only(), "progress"_a = py::none(),
            "Writes what is below a node, or the root, as an RVM file. `progress` as in import_file().");
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
