// The graphs of A. L. dos Santos, "Estruturas de Aceleração para Ray Tracing em Tempo Real: um Estudo Comparativo"
// (2011), chapter 6, as tables.
#include "sightline/study/tables/rays.h"

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/model.h"
#include "sightline/apps/common/output.h"
#include "sightline/apps/common/progress.h"
#include "sightline/apps/common/svg_plot.h"
#include "sightline/importers/json/internal/json.h"
#include "sightline/study/rays/benchmark.h"
#include "sightline/study/rays/generated_meshes.h"
#include "sightline/study/tables/ray_models.h"
#ifdef SIGHTLINE_STUDY_HAS_GPU
#include "sightline/study/tables/rays_gpu.h"
#endif

namespace sightline::study {
namespace {

using namespace rays;
using Json = json::Value;

constexpr const char* kReference = "kd ropes++";  // the dissertation's fastest

struct Options {
  bool tables = false, gpu = false;
  std::string csv, json, size = "1408x768";
  int passes = 3;
  std::vector<std::size_t> scans{1000, 10'000, 100'000, 1'080'000, 4'000'000}, scattered{1'080'000};
  apps::ModelOptions files;
};

// --- models ----------------------------------------------------------------------------------------------------------

struct NamedModel {
  std::string name;
  std::function<core::Expected<TriangleSet>()> make;
};

std::vector<NamedModel> models_of(const Options& options) {
  std::vector<NamedModel> models;
  for (const std::string& file : options.files.files)
    models.push_back({std::filesystem::path(file).stem().string(), [&options, file]() -> core::Expected<TriangleSet> {
                        auto mesh = load_triangles(options.files, file);
                        if (!mesh) return tl::unexpected(mesh.error());
                        return TriangleSet(mesh->positions, mesh->indices);
                      }});
  const auto add = [&](const char* name, std::size_t triangles, GeneratedMesh (*make)(std::size_t)) {
    models.push_back({name, [triangles, make]() -> core::Expected<TriangleSet> {
                        const GeneratedMesh mesh = make(triangles);
                        return TriangleSet(mesh.positions, mesh.indices);
                      }});
  };
  for (const std::size_t n : options.scans) add("scan", n, make_scan);
  for (const std::size_t n : options.scattered) add("scattered", n, make_scattered);
  return models;
}

// --- output ----------------------------------------------------------------------------------------------------------

double ratio(double value, double reference) {
  return reference > 0.0 ? value / reference : 0.0;
}

void print_benchmark(const Benchmark& b) {
  const TraversalRun& best = *b.find(kReference);
  std::printf("\n%s, %zu triangles: %zu primary rays, %.1f %% hit; brute force %.0f ns a ray\n", b.model.c_str(),
              b.triangles, b.rays[0], 100.0 * b.hits, b.brute_force_ns);
  std::printf("%-20s %8s %8s %9s %8s %8s %9s %6s %6s %6s %6s %6s\n", "graphs 6-1 4 5 8", "ns/ray", "/ropes++",
              "reflected", "shadow", "nodes", "triangles", "rows", "tiles", "rows", "tiles", "differ");
  for (const TraversalRun& r : b.traversals)
    std::printf("%-20s %8.0f %8.2f %9.0f %8.0f %8.1f %9.1f %6.2f %6.2f %6.3f %6.3f %6zu\n", r.traversal->name, r.ns[0],
                ratio(r.ns[0], best.ns[0]), r.ns[1], r.ns[2], r.nodes, r.triangles, r.lanes_rows, r.lanes_tiles,
                r.balance_rows, r.balance_tiles, r.disagreements);
  const double ropes = double(b.structures[std::size_t(best.traversal->structure)].bytes);
  std::printf("%-20s %12s %8s %10s\n", "graphs 6-2 3", "B/triangle", "/ropes", "build s");
  for (const StructureRun& s : b.structures)
    std::printf("%-20s %12.1f %8.2f %10.2f\n", name_of(s.structure), double(s.bytes) / double(b.triangles),
                double(s.bytes) / ropes, s.build_seconds);
  std::fflush(stdout);  // the next model takes minutes
}

void print_growth(const std::vector<Benchmark>& all) {
  std::printf("\n%-20s", "graph 6-7 (ns a ray)");
  for (const Benchmark& b : all)
    std::printf(" %12s", (b.model.substr(0, 4) + " " + std::to_string(b.triangles)).c_str());
  for (std::size_t i = 0; i < all.front().traversals.size(); ++i) {
    std::printf("\n%-20s", all.front().traversals[i].traversal->name);
    for (const Benchmark& b : all) std::printf(" %12.0f", b.traversals[i].ns[0]);
  }
  std::printf("\n%-20s", "brute force");
  for (const Benchmark& b : all) std::printf(" %12.0f", b.brute_force_ns);
  std::printf("\n");
}

Json to_json(const Benchmark& b) {
  Json json{{"model", b.model}, {"triangles", b.triangles}, {"hits", b.hits}, {"brute_force_ns", b.brute_force_ns}};
  for (std::size_t k = 0; k < kRayKinds; ++k) json["rays"][name_of(RayKind(k))] = b.rays[k];
  for (const TraversalRun& r : b.traversals) {
    Json run{{"name", r.traversal->name}, {"structure", name_of(r.traversal->structure)}};
    for (std::size_t k = 0; k < kRayKinds; ++k) run["ns"][name_of(RayKind(k))] = r.ns[k];
    run.update({{"nodes", r.nodes},
                {"triangles", r.triangles},
                {"lanes_rows", r.lanes_rows},
                {"lanes_tiles", r.lanes_tiles},
                {"balance_rows", r.balance_rows},
                {"balance_tiles", r.balance_tiles},
                {"disagreements", r.disagreements}});
    if (r.gpu)
      run["glsl"] = {{"ns",
                      {{"rows", r.gpu->rows_ns},
                       {"tiles", r.gpu->tiles_ns},
                       {"persistent", r.gpu->persistent_ns},
                       {"reflected", r.gpu->reflected_ns},
                       {"shadow", r.gpu->shadow_ns}}},
                     {"nodes", r.gpu->nodes},
                     {"triangles", r.gpu->triangles},
                     {"divergence_rows", r.gpu->divergence_rows},
                     {"divergence_tiles", r.gpu->divergence_tiles},
                     {"disagreements", r.gpu->disagreements}};
    json["traversals"].push_back(std::move(run));
  }
  for (const StructureRun& s : b.structures)
    json["structures"].push_back(
        {{"name", name_of(s.structure)}, {"bytes", s.bytes}, {"build_seconds", s.build_seconds}});
  return json;
}

/// One line a traversal, or a structure, of each model.
core::Expected<void> write_csv(const std::vector<Benchmark>& all, const std::filesystem::path& directory) {
  std::string traversals =
      "model,triangles,traversal,primary ns,reflected ns,shadow ns,nodes,triangles tested,lanes rows,lanes tiles,"
      "balance rows,balance tiles\n";
  std::string structures = "model,triangles,structure,bytes,build seconds\n";
  for (const Benchmark& b : all) {
    const std::string model = b.model + ',' + std::to_string(b.triangles) + ',';
    for (const TraversalRun& r : b.traversals) {
      traversals += model + csv_field(r.traversal->name);
      for (const double v : {r.ns[0], r.ns[1], r.ns[2], r.nodes, r.triangles, r.lanes_rows, r.lanes_tiles,
                             r.balance_rows, r.balance_tiles})
        traversals += ',' + std::to_string(v);
      traversals += '\n';
    }
    for (const StructureRun& s : b.structures)
      structures += model + csv_field(name_of(s.structure)) + ',' + std::to_string(s.bytes) + ',' +
                    std::to_string(s.build_seconds) + '\n';
  }
  if (auto w = apps::write_text((directory / "rays_traversals.csv").string(), traversals); !w) return w;
  return apps::write_text((directory / "rays_structures.csv").string(), structures);
}

/// Graph 6-7 of the scans.
core::Expected<void> write_growth(const std::vector<Benchmark>& all, const std::filesystem::path& directory) {
  using Look = apps::PanelSeries::Style;
  std::vector<apps::PanelSeries> lines;
  for (std::size_t i = 0; i < all.front().traversals.size(); ++i) {
    lines.push_back({all.front().traversals[i].traversal->name, {}, Look::kLine});
    for (const Benchmark& b : all)
      if (b.model == "scan") lines.back().points.push_back({double(b.triangles), b.traversals[i].ns[0], {}});
  }
  lines.push_back({"brute force", {}, Look::kDashes});
  for (const Benchmark& b : all)
    if (b.model == "scan") lines.back().points.push_back({double(b.triangles), b.brute_force_ns, {}});
  return apps::write_text((directory / "rays_growth.svg").string(),
                          apps::svg_panels({.title = "Graph 6-7: time against number of triangles",
                                            .x_label = "triangles",
                                            .y_label = "ns a primary ray",
                                            .panels = {{"", std::move(lines)}},
                                            .large = true}));
}

core::Expected<int> run_rays(const Options& options) {
  const auto size = apps::parse_size(options.size);
  if (!size) return tl::unexpected(size.error());
  const bool print = options.tables && options.json != "-";
  BenchmarkHook then;
#ifdef SIGHTLINE_STUDY_HAS_GPU
  RaysOnGpu gpu(options.passes);
  if (options.gpu) {
    if (auto done = gpu.begin(print); !done) return tl::unexpected(done.error());
    then = [&](const Structures& s, const BenchmarkRays& rays, Benchmark& benchmark) { gpu.run(s, rays, benchmark); };
  }
#endif
  std::vector<Benchmark> all;
  for (const NamedModel& model : models_of(options)) {
    auto triangles = model.make();
    if (!triangles) return tl::unexpected(triangles.error());
    if (triangles->size() == 0) return core::fail(model.name + ": no triangles");
    all.push_back(run_benchmark(
        model.name, *triangles, {(*size)[0], (*size)[1]}, options.passes,
        [&](const std::string& what) { apps::show_step(model.name + ": " + what); }, then));
    apps::show_step("");
    if (print) print_benchmark(all.back());
#ifdef SIGHTLINE_STUDY_HAS_GPU
    if (!gpu.done()) return tl::unexpected(gpu.done().error());
    if (print && options.gpu) print_gpu(all.back());
#endif
  }
  if (all.empty()) return core::fail("rays: no models");
  if (print) print_growth(all);
  if (!options.csv.empty()) {
    if (auto made = apps::make_directory(options.csv); !made) return tl::unexpected(made.error());
    if (auto w = write_csv(all, options.csv); !w) return tl::unexpected(w.error());
    if (auto w = write_growth(all, options.csv); !w) return tl::unexpected(w.error());
#ifdef SIGHTLINE_STUDY_HAS_GPU
    if (options.gpu)
      if (auto w = write_gpu_csv(all, options.csv); !w) return tl::unexpected(w.error());
#endif
  }
  Json json = Json::array();
  for (const Benchmark& b : all) json.push_back(to_json(b));
  if (auto w = apps::write_json(options.json, json); !w) return tl::unexpected(w.error());
  return apps::kExitOk;
}

}  // namespace

std::string csv_field(const std::string& text) {
  return text.find(',') == std::string::npos ? text : '"' + text + '"';
}

std::function<core::Expected<int>()> add_rays(apps::CommandLine& line) {
  const auto options = std::make_shared<Options>();
  line.add_flag("--tables", options->tables, "print the tables (not with --json -)");
  line.add("--csv", options->csv, "write the tables' data and a plot into this directory");
  apps::add_json_option(line, options->json);
  line.add("--size", options->size, "of the image, WxH").accepted_by(apps::parse_size);
  line.add("--passes", options->passes, "times each traversal runs; the fastest counts").in_range(1, 1000);
  constexpr std::size_t kFewest = 12, kMost = 100'000'000;
  line.add("--scan", options->scans, "triangles of generated scans; 12 at least")
      .separated_by(',')
      .in_range(kFewest, kMost);
  line.add("--scattered", options->scattered, "triangles of generated scenes of a hundred scans")
      .separated_by(',')
      .in_range(kFewest, kMost);
  line.add("--model", options->files.files, "real models besides (RVM, OBJ, PLY …), each on its own");
#ifdef SIGHTLINE_STUDY_HAS_GPU
  line.add_flag("--gpu", options->gpu, "the traversals in GLSL besides");
#endif
  return [options] { return run_rays(*options); };
}

}  // namespace sightline::study
