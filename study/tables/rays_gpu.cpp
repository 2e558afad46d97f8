#include "sightline/study/tables/rays_gpu.h"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>

#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/output.h"
#include "sightline/apps/common/progress.h"
#include "sightline/apps/common/svg_plot.h"
#include "sightline/study/rays/gpu/benchmark.h"
#include "sightline/study/rays/gpu/grid_study.h"
#include "sightline/study/tables/ray_models.h"
#include "sightline/study/tables/rays.h"

namespace sightline::study {

using namespace rays;

namespace {

core::Expected<gl::Context> make_context(bool print) {
  auto made = gl::Context::create_offscreen();
  if (made && print)
    std::printf("%s%s\n", made->renderer().c_str(),
                made->capabilities().software ? ": the GPU's work is the CPU's here" : "");
  return made;
}

}  // namespace

// --- rays --gpu ------------------------------------------------------------------------------------------------------

core::Expected<void> RaysOnGpu::begin(bool print) {
  auto made = make_context(print);
  if (!made) return tl::unexpected(made.error());
  context_.emplace(std::move(*made));
  return {};
}

void RaysOnGpu::run(const Structures& structures, const BenchmarkRays& searched, Benchmark& benchmark) {
  const auto step = [&](const std::string& what) { apps::show_step(benchmark.model + ": " + what); };
  auto left_out = run_on_gpu(*context_, structures, searched, passes_, step, benchmark);
  apps::show_step("");
  if (!left_out) {
    done_ = tl::unexpected(left_out.error());
    return;
  }
  for (const std::string& line : *left_out)
    std::fprintf(stderr, "%s is left out in GLSL: %s\n", benchmark.model.c_str(), line.c_str());
}

void print_gpu(const Benchmark& b) {
  std::printf("%-20s %8s %8s %10s %9s %8s %8s %9s %10s %10s %6s\n", "in GLSL (ns a ray)", "rows", "tiles", "persistent",
              "reflected", "shadow", "nodes", "triangles", "div. rows", "div. tiles", "differ");
  for (const TraversalRun& r : b.traversals)
    if (r.gpu)
      std::printf("%-20s %8.0f %8.0f %10.0f %9.0f %8.0f %8.1f %9.1f %10.2f %10.2f %6zu\n", r.traversal->name,
                  r.gpu->rows_ns, r.gpu->tiles_ns, r.gpu->persistent_ns, r.gpu->reflected_ns, r.gpu->shadow_ns,
                  r.gpu->nodes, r.gpu->triangles, r.gpu->divergence_rows, r.gpu->divergence_tiles,
                  r.gpu->disagreements);
  std::fflush(stdout);
}

core::Expected<void> write_gpu_csv(const std::vector<Benchmark>& all, const std::filesystem::path& directory) {
  std::string text =
      "model,triangles,traversal,rows ns,tiles ns,persistent ns,reflected ns,shadow ns,nodes,triangles tested,"
      "divergence rows,divergence tiles,disagreements\n";
  for (const Benchmark& b : all)
    for (const TraversalRun& r : b.traversals) {
      if (!r.gpu) continue;
      text += b.model + ',' + std::to_string(b.triangles) + ',' + csv_field(r.traversal->name);
      for (const double v :
           {r.gpu->rows_ns, r.gpu->tiles_ns, r.gpu->persistent_ns, r.gpu->reflected_ns, r.gpu->shadow_ns, r.gpu->nodes,
            r.gpu->triangles, r.gpu->divergence_rows, r.gpu->divergence_tiles})
        text += ',' + std::to_string(v);
      text += ',' + std::to_string(r.gpu->disagreements) + '\n';
    }
  return apps::write_text((directory / "rays_glsl.csv").string(), text);
}

// --- grids -----------------------------------------------------------------------------------------------------------

namespace {

struct GridOptions {
  bool tables = false;
  std::string csv, bunny, size = "640x480";  // the dissertation's
  std::vector<std::string> only;
  int passes = 3;
};

double per_second(double ms) {
  return ms > 0.0 ? 1e3 / ms : 0.0;
}

void print_grids(const GridRun& run) {
  std::printf("\n%s, %zu triangles, %d light%s (tables %s)\n", run.scene->name.c_str(), run.triangles,
              run.scene->lights, run.scene->lights == 1 ? "" : "s", run.scene->tables.c_str());
  std::printf("%6s %11s %13s %13s %9s %9s %9s %6s\n", "cells", "references", "CPU build ms", "GPU build ms", "CPU fps",
              "GPU fps", "speed-up", "differ");
  for (const GridImage& p : run.images)
    std::printf("%6d %11zu %13.2f %13.2f %9.2f %9.2f %9.2f %6zu\n", p.size, p.references, p.cpu_build_ms,
                p.gpu_build_ms, per_second(p.cpu_ms), per_second(p.gpu_ms), p.cpu_ms / p.gpu_ms, p.disagreements);
  std::fflush(stdout);
}

core::Expected<void> write_grids(const std::vector<GridRun>& all, const std::filesystem::path& directory) {
  std::string text =
      "tables,scene,triangles,lights,cells,references,CPU build ms,GPU build ms,CPU fps,GPU fps,disagreements\n";
  for (const GridRun& run : all)
    for (const GridImage& p : run.images) {
      text += run.scene->tables + ',' + run.scene->name;
      for (const std::size_t v : {run.triangles, std::size_t(run.scene->lights), std::size_t(p.size), p.references})
        text += ',' + std::to_string(v);
      for (const double v : {p.cpu_build_ms, p.gpu_build_ms, per_second(p.cpu_ms), per_second(p.gpu_ms)})
        text += ',' + std::to_string(v);
      text += ',' + std::to_string(p.disagreements) + '\n';
    }
  return apps::write_text((directory / "grids.csv").string(), text);
}

core::Expected<int> run_grid_study(const GridOptions& options) {
  const auto size = apps::parse_size(options.size);
  if (!size) return tl::unexpected(size.error());
  auto context = make_context(options.tables);
  if (!context) return tl::unexpected(context.error());
  auto builder = GridBuilder::create(*context);
  if (!builder) return tl::unexpected(builder.error());
  GpuTracer tracer(*context);
  std::vector<GridScene> scenes = grid_scenes();
  if (!options.bunny.empty()) {
    auto mesh = load_triangles({}, options.bunny);
    if (!mesh) return tl::unexpected(mesh.error());
    for (GridScene& scene : scenes)
      if (scene.name == "BUNNY") scene.mesh = *mesh;
  }
  std::vector<GridRun> all;
  for (const GridScene& scene : scenes) {
    const auto& only = options.only;
    if (!only.empty() && std::find(only.begin(), only.end(), scene.name) == only.end()) continue;
    auto run = run_grids(*context, *builder, tracer, scene, {(*size)[0], (*size)[1]}, options.passes,
                         [](const std::string& what) { apps::show_step(what); });
    apps::show_step("");
    if (!run) return core::fail(scene.name + ": " + run.error().message);
    all.push_back(std::move(*run));
    if (options.tables) print_grids(all.back());
  }
  if (all.empty()) return core::fail("grids: no scene has one of these names");
  if (options.csv.empty()) return apps::kExitOk;
  if (auto made = apps::make_directory(options.csv); !made) return tl::unexpected(made.error());
  if (auto w = write_grids(all, options.csv); !w) return tl::unexpected(w.error());
  return apps::kExitOk;
}

}  // namespace

std::function<core::Expected<int>()> add_grids(apps::CommandLine& line) {
  const auto options = std::make_shared<GridOptions>();
  line.add_flag("--tables", options->tables, "print the tables");
  line.add("--csv", options->csv, "write the tables' data into this directory");
  line.add("--only", options->only, "these scenes alone: PRI_I to PRI_V, DIST_I to DIST_III, BUNNY, DRAGON, ALEXANDRA");
  line.add("--bunny", options->bunny, "model of the scene BUNNY, instead of a generated scan");
  line.add("--size", options->size, "of the image, WxH").accepted_by(apps::parse_size);
  line.add("--passes", options->passes, "times each image is made; the fastest counts").in_range(1, 1000);
  return [options] { return run_grid_study(*options); };
}

}  // namespace sightline::study
