// The subcommand rays on the GPU (--gpu), and sightline-study grids.
#include <algorithm>
#include <memory>

#include "sightline/apps/bench/renderer.h"
#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/output.h"
#include "sightline/apps/common/progress.h"
#include "sightline/apps/study/rays/gpu/benchmark.h"
#include "sightline/apps/study/rays/gpu/grid_study.h"
#include "sightline/apps/study/tables/rays.h"
#include "sightline/apps/study/tables/subcommands.h"

namespace sightline::study::rays {
namespace {

struct GridOptions {
  std::string json, bunny, size = "640x480";  // the dissertation's
  std::vector<std::string> only;
  int passes = 3;
};

double images_per_second(double ms) {
  return ms > 0.0 ? 1e3 / ms : 0.0;
}

void print_grids(const GridRun& run, std::FILE* out) {
  std::fprintf(out, "\n%s, %zu triangles, %d light%s (tables %s)\n", run.scene->name.c_str(), run.triangles,
               run.scene->lights, run.scene->lights == 1 ? "" : "s", run.scene->tables.c_str());
  std::fprintf(out, "%6s %11s %9s %9s %9s %9s %6s\n", "cells", "references", "build ms", "CPU fps", "GPU fps",
               "speed-up", "differ");
  for (const GridImage& p : run.images)
    std::fprintf(out, "%6d %11zu %9.2f %9.2f %9.2f %9.2f %6zu\n", p.size, p.references, p.build_ms,
                 images_per_second(p.cpu_ms), images_per_second(p.gpu_ms), p.cpu_ms / p.gpu_ms, p.disagreements);
  std::fflush(out);
}

json::Value to_json(const GridRun& run) {
  json::Value images = json::Value::array();
  for (const GridImage& p : run.images)
    images.push_back({{"cells", p.size},
                      {"references", p.references},
                      {"build_ms", p.build_ms},
                      {"cpu_ms", p.cpu_ms},
                      {"gpu_ms", p.gpu_ms},
                      {"disagreements", p.disagreements}});
  return {{"scene", run.scene->name},
          {"tables", run.scene->tables},
          {"triangles", run.triangles},
          {"lights", run.scene->lights},
          {"images", std::move(images)}};
}

core::Expected<int> run_grid_study(const GridOptions& options) {
  const auto size = apps::parse_size(options.size);
  if (!size) return tl::unexpected(size.error());
  auto context = gl::Context::create_offscreen();
  if (!context) return tl::unexpected(context.error());
  std::FILE* out = apps::table_stream(options.json);
  std::fprintf(out, "%s\n", bench::renderer_line(*context).c_str());
  GpuTracer tracer(*context);
  std::vector<GridScene> scenes = grid_scenes();
  const auto& only = options.only;
  std::erase_if(scenes, [&](const GridScene& scene) {
    return !only.empty() && std::find(only.begin(), only.end(), scene.name) == only.end();
  });
  if (scenes.empty()) return core::fail("grids: no scene has one of these names");
  json::Value json = json::Value::array();
  for (GridScene& scene : scenes) {
    if (scene.name == "BUNNY" && !options.bunny.empty()) {
      auto mesh = load_triangles({}, options.bunny);
      if (!mesh) return tl::unexpected(mesh.error());
      scene.mesh = std::move(*mesh);
    }
    auto run = run_grids(*context, tracer, scene, {(*size)[0], (*size)[1]}, options.passes, apps::show_step);
    apps::show_step("");
    if (!run) return core::fail(scene.name + ": " + run.error().message);
    print_grids(*run, out);
    json.push_back(to_json(*run));
  }
  return bench::finish(options.json, json);
}

void add_grid_options(apps::CommandLine& line, GridOptions& options) {
  apps::add_json_option(line, options.json);
  line.add("--only", options.only, "These scenes alone: PRI_I to PRI_V, DIST_I to DIST_III, BUNNY, DRAGON, ALEXANDRA");
  line.add("--bunny", options.bunny, "Model of the scene BUNNY, instead of a generated scan");
  line.add("--size", options.size, "Of the image, WxH").accepted_by(apps::parse_size);
  line.add("--passes", options.passes, "Times each image is made; the fastest counts").in_range(1, 1000);
  line.examples("  sightline-study grids --only DIST_I DIST_II");
}

}  // namespace

core::Expected<BenchmarkHook> rays_on_gpu(int passes, std::FILE* out) {
  auto made = gl::Context::create_offscreen();
  if (!made) return tl::unexpected(made.error());
  const auto context = std::make_shared<gl::Context>(std::move(*made));
  std::fprintf(out, "%s\n", bench::renderer_line(*context).c_str());
  return [context, passes](const Structures& structures, const BenchmarkRays& searched,
                           Benchmark& benchmark) -> core::Expected<void> {
    const auto step = [&](const std::string& what) { apps::show_step(benchmark.model + ": " + what); };
    const auto left_out = run_on_gpu(*context, structures, searched, passes, step, benchmark);
    if (!left_out) return tl::unexpected(left_out.error());
    for (const std::string& line : *left_out)
      std::fprintf(stderr, "%s is left out in GLSL: %s\n", benchmark.model.c_str(), line.c_str());
    return {};
  };
}

bench::Run add_grids(apps::CommandLine& line) {
  return bench::add_subcommand<GridOptions>(line, add_grid_options, run_grid_study);
}

}  // namespace sightline::study::rays
