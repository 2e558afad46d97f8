// sightline-study rays: the graphs of A. L. dos Santos, "Estruturas de Aceleração para Ray Tracing em Tempo Real: um
// Estudo Comparativo" (2011), chapter 6, as tables.
#include "sightline/apps/study/tables/rays.h"

#include <cstdio>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/model.h"
#include "sightline/apps/common/output.h"
#include "sightline/apps/common/progress.h"
#include "sightline/apps/common/svg_plot.h"
#include "sightline/apps/common/tessellated_scene.h"
#include "sightline/apps/study/rays/benchmark.h"
#include "sightline/apps/study/rays/generated_meshes.h"
#include "sightline/apps/study/tables/subcommands.h"
#include "sightline/core/snapshot.h"

namespace sightline::study::rays {
namespace {

using Json = json::Value;

constexpr const char* kReference = "kd ropes++";  // the dissertation's fastest

struct RaysOptions {
  bool gpu = false;
  std::string plot, json, size = "1408x768";
  int passes = 3;
  std::vector<std::size_t> scans{1000, 10'000, 100'000, 1'080'000, 4'000'000}, scattered{1'080'000};
  apps::ModelOptions files;
};

// --- models ----------------------------------------------------------------------------------------------------------

GeneratedMesh triangles_of(const core::Scene& scene) {
  constexpr int kSegments = 24;
  const core::Scene whole = apps::tessellated(scene, kSegments);
  const core::Snapshot snapshot(whole);
  std::vector<core::dvec3> positions;
  std::vector<std::uint32_t> indices;
  core::AabbD bounds;
  for (core::Slot s = 0; s < snapshot.size(); ++s) {
    if (snapshot.vacant(s) || snapshot.kind(s) != core::Kind::kMesh) continue;
    const core::Affine world_from_item = snapshot.world_from_item(s);
    const core::Mesh& mesh = snapshot.mesh(s);
    const std::uint32_t first = std::uint32_t(positions.size());
    for (const core::vec3& p : mesh.positions) {
      positions.push_back(core::transform_point(world_from_item, core::dvec3(p)));
      bounds.grow(positions.back());
    }
    for (const std::uint32_t i : mesh.indices) indices.push_back(first + i);
  }
  std::vector<core::vec3> centred;
  centred.reserve(positions.size());
  for (const core::dvec3& p : positions) centred.push_back(core::vec3(p - bounds.centre()));
  return {std::move(centred), std::move(indices)};
}

struct NamedModel {
  std::string name;
  std::function<core::Expected<TriangleSet>()> make;
};

std::vector<NamedModel> models_of(const RaysOptions& options) {
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

/// Prints nothing where the traversals did not run on a GPU.
void print_glsl(const Benchmark& b, std::FILE* out) {
  const char* title = "in GLSL (ns a ray)";
  for (const TraversalRun& r : b.traversals) {
    if (!r.gpu) continue;
    if (title != nullptr)
      std::fprintf(out, "%-20s %8s %8s %10s %9s %8s %6s\n", std::exchange(title, nullptr), "rows", "tiles",
                   "persistent", "reflected", "shadow", "differ");
    std::fprintf(out, "%-20s %8.0f %8.0f %10.0f %9.0f %8.0f %6zu\n", r.traversal->name, r.gpu->rows_ns, r.gpu->tiles_ns,
                 r.gpu->persistent_ns, r.gpu->reflected_ns, r.gpu->shadow_ns, r.gpu->disagreements);
  }
}

void print_benchmark(const Benchmark& b, std::FILE* out) {
  const TraversalRun& best = *b.find(kReference);
  std::fprintf(out, "\n%s, %zu triangles: %zu primary rays, %.1f %% hit; brute force %.0f ns a ray\n", b.model.c_str(),
               b.triangles, b.rays[0], 100.0 * b.hits, b.brute_force_ns);
  std::fprintf(out, "%-20s %8s %8s %9s %8s %8s %9s %6s %6s %6s %6s %6s\n", "graphs 6-1 4 5 8", "ns/ray", "/ropes++",
               "reflected", "shadow", "nodes", "triangles", "rows", "tiles", "rows", "tiles", "differ");
  for (const TraversalRun& r : b.traversals)
    std::fprintf(out, "%-20s %8.0f %8.2f %9.0f %8.0f %8.1f %9.1f %6.2f %6.2f %6.3f %6.3f %6zu\n", r.traversal->name,
                 r.ns[0], ratio(r.ns[0], best.ns[0]), r.ns[1], r.ns[2], r.nodes, r.triangles, r.lanes_rows,
                 r.lanes_tiles, r.balance_rows, r.balance_tiles, r.disagreements);
  const double ropes = double(b.structures[std::size_t(best.traversal->structure)].bytes);
  std::fprintf(out, "%-20s %12s %8s %10s\n", "graphs 6-2 3", "B/triangle", "/ropes", "build s");
  for (const StructureRun& s : b.structures)
    std::fprintf(out, "%-20s %12.1f %8.2f %10.2f\n", name_of(s.structure), double(s.bytes) / double(b.triangles),
                 double(s.bytes) / ropes, s.build_seconds);
  print_glsl(b, out);
  std::fflush(out);  // the next model takes minutes
}

void print_growth(const std::vector<Benchmark>& all, std::FILE* out) {
  std::fprintf(out, "\n%-20s", "graph 6-7 (ns a ray)");
  for (const Benchmark& b : all)
    std::fprintf(out, " %12s", (b.model.substr(0, 4) + " " + std::to_string(b.triangles)).c_str());
  for (std::size_t i = 0; i < all.front().traversals.size(); ++i) {
    std::fprintf(out, "\n%-20s", all.front().traversals[i].traversal->name);
    for (const Benchmark& b : all) std::fprintf(out, " %12.0f", b.traversals[i].ns[0]);
  }
  std::fprintf(out, "\n%-20s", "brute force");
  for (const Benchmark& b : all) std::fprintf(out, " %12.0f", b.brute_force_ns);
  std::fprintf(out, "\n");
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
                     {"disagreements", r.gpu->disagreements}};
    json["traversals"].push_back(std::move(run));
  }
  for (const StructureRun& s : b.structures)
    json["structures"].push_back(
        {{"name", name_of(s.structure)}, {"bytes", s.bytes}, {"build_seconds", s.build_seconds}});
  return json;
}

/// Graph 6-7 of the scans.
std::string growth_plot(const std::vector<Benchmark>& all) {
  using Style = apps::PanelSeries::Style;
  std::vector<apps::PanelSeries> lines;
  const auto add = [&](const char* name, Style style, const auto& ns_of) {
    lines.push_back({name, {}, style});
    for (const Benchmark& b : all)
      if (b.model == "scan") lines.back().points.push_back({double(b.triangles), ns_of(b), {}});
  };
  for (std::size_t i = 0; i < all.front().traversals.size(); ++i)
    add(all.front().traversals[i].traversal->name, Style::kLine,
        [i](const Benchmark& b) { return b.traversals[i].ns[0]; });
  add("brute force", Style::kDashes, [](const Benchmark& b) { return b.brute_force_ns; });
  return apps::svg_panels({.title = "Graph 6-7: time against number of triangles",
                           .x_label = "triangles",
                           .y_label = "ns a primary ray",
                           .panels = {{"", std::move(lines)}},
                           .large = true});
}

core::Expected<int> run_rays(const RaysOptions& options) {
  const auto size = apps::parse_size(options.size);
  if (!size) return tl::unexpected(size.error());
  std::FILE* out = apps::table_stream(options.json);
  BenchmarkHook then;
#if SIGHTLINE_STUDY_HAS_GPU
  if (options.gpu) {
    auto made = rays_on_gpu(options.passes, out);
    if (!made) return tl::unexpected(made.error());
    then = std::move(*made);
  }
#endif
  std::vector<Benchmark> all;
  Json json = Json::array();
  for (const NamedModel& model : models_of(options)) {
    auto triangles = model.make();
    if (!triangles) return tl::unexpected(triangles.error());
    if (triangles->size() == 0) return core::fail(model.name + ": no triangles");
    auto benchmark = run_benchmark(
        model.name, *triangles, {(*size)[0], (*size)[1]}, options.passes,
        [&](const std::string& what) { apps::show_step(model.name + ": " + what); }, then);
    apps::show_step("");
    if (!benchmark) return tl::unexpected(benchmark.error());
    all.push_back(std::move(*benchmark));
    print_benchmark(all.back(), out);
    json.push_back(to_json(all.back()));
  }
  if (all.empty()) return core::fail("rays: no models");
  print_growth(all, out);
  if (!options.plot.empty())
    if (auto w = apps::write_text(options.plot, growth_plot(all)); !w) return tl::unexpected(w.error());
  return bench::finish(options.json, json);
}

void add_rays_options(apps::CommandLine& line, RaysOptions& options) {
  line.add("--plot", options.plot, "Time against number of triangles, SVG");
  apps::add_json_option(line, options.json);
  line.add("--size", options.size, "Of the image, WxH").accepted_by(apps::parse_size);
  line.add("--passes", options.passes, "Times each traversal runs; the fastest counts").in_range(1, 1000);
  constexpr std::size_t kFewest = 12, kMost = 100'000'000;
  line.add("--scan", options.scans, "Triangles of generated scans; 12 at least")
      .separated_by(',')
      .in_range(kFewest, kMost);
  line.add("--scattered", options.scattered, "Triangles of generated scenes of a hundred scans")
      .separated_by(',')
      .in_range(kFewest, kMost);
  line.add("--model", options.files.files, "Real models besides (RVM, OBJ, PLY …), each on its own");
#if SIGHTLINE_STUDY_HAS_GPU
  line.add_flag("--gpu", options.gpu, "The traversals in GLSL besides");
#endif
  line.examples("  sightline-study rays --scan 100000 --plot growth.svg");
}

}  // namespace

core::Expected<GeneratedMesh> load_triangles(apps::ModelOptions options, const std::string& file) {
  options.files = {file};
  auto loaded = apps::load_model(options);
  if (!loaded) return tl::unexpected(loaded.error());
  return triangles_of(*loaded->scene);
}

bench::Run add_rays(apps::CommandLine& line) {
  return bench::add_subcommand<RaysOptions>(line, add_rays_options, run_rays);
}

}  // namespace sightline::study::rays
