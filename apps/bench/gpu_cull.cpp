// sightline-bench gpu-cull: compares the variants of the GPU culler and of its boxes with each other. Draws no image.
//
// Culls generated plants along an orbit. Every variant culls each view in turn, and the best of some passes counts: the
// time from submission until the GPU has finished, and the part of it for the submission. Memory as in table 5.1 of E.
// T. Carlos, "Frustum Culling Híbrido Utilizando CPU e GPU" (PUC-Rio, 2009): all boxes, for plants of its sizes.
#include <cstdio>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include "sightline/apps/bench/harness.h"
#include "sightline/apps/bench/models/platforms.h"
#include "sightline/apps/bench/renderer.h"
#include "sightline/apps/bench/subcommands.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/model.h"
#include "sightline/apps/common/output.h"
#include "sightline/culling/frustum/cpu_culler.h"
#include "sightline/culling/gpu/internal/gpu_culler.h"
#include "sightline/importers/json/internal/json.h"
#include "sightline/importers/plant/plant_generator.h"

namespace sightline::bench::gpu_cull_bench {
namespace {

using Json = json::Value;
using culling::GpuCuller;
using culling::GpuVariant;

constexpr GpuVariant kVariants[] = {GpuVariant::kGeometry, GpuVariant::kCompute};

struct Options {
  std::vector<std::uint64_t> items;  // per plant; none: those of kPlatforms
  int views = 24, passes = 5;
  gl::ContextPlatform platform = {};
  std::string json;
};

struct Subject {
  GpuCuller culler;
  std::vector<double> total, submit;  // per view: the best so far, milliseconds
  std::uint64_t visible = 0;          // sum over all views
};

std::vector<core::View> orbit(const core::Snapshot& snapshot, int count) {
  const core::Aabb& extent = snapshot.bounds().extent();
  const core::dvec3 size = core::dvec3(extent.max) - core::dvec3(extent.min);
  const core::dvec3 centre = snapshot.bounds().origin + 0.5 * (core::dvec3(extent.min) + core::dvec3(extent.max));
  std::vector<core::View> views;
  for (int i = 0; i < count; ++i) {
    const double turn = 2.0 * std::numbers::pi * i / count, reach = 0.05 + 0.45 * (0.5 + 0.5 * std::cos(3.0 * turn));
    const core::dvec3 target = centre + 0.2 * size * core::dvec3(std::cos(2.0 * turn), std::sin(2.0 * turn), 0.0);
    const core::dvec3 eye = target + reach * glm::length(size) * core::dvec3(std::cos(turn), std::sin(turn), 0.3);
    views.push_back(*core::View::perspective({eye, target, {0, 0, 1}}, 0.9, 16.0 / 9.0, 0.1));
  }
  return views;
}

double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v;
  return sum / double(values.size());
}

core::Expected<Json> measure(const gl::Context& context, std::uint64_t items, const Options& o, std::FILE* out) {
  core::Scene scene;
  importers::PlantConfig plant;
  plant.items = items;
  if (auto made = importers::generate_plant(plant, scene); !made) return tl::unexpected(made.error());
  if (auto done = scene.commit(); !done) return tl::unexpected(done.error());
  const core::Snapshot snapshot(scene);
  auto gpu = gpuscene::GpuScene::create(context, snapshot);
  if (!gpu) return tl::unexpected(gpu.error());
  auto lists = gpuscene::DrawLists::create(context, *gpu);
  if (!lists) return tl::unexpected(lists.error());

  const std::vector<core::View> views = orbit(snapshot, o.views);
  std::vector<Subject> subjects;
  for (const GpuVariant variant : kVariants) {
    auto culler = GpuCuller::create(context, snapshot, *gpu, {variant});
    if (!culler) return tl::unexpected(culler.error());
    const std::vector<double> unknown(views.size(), 1e9);
    subjects.push_back({std::move(*culler), unknown, unknown});
  }
  const gl::Functions& gl = context.functions();
  for (int pass = 0; pass < o.passes; ++pass) {
    for (std::size_t i = 0; i < views.size(); ++i) {
      for (Subject& subject : subjects) {
        gl.Finish();
        const double start = milliseconds();
        if (auto done = subject.culler.cull(views[i], snapshot, *gpu, *lists); !done)
          return tl::unexpected(done.error());
        subject.submit[i] = std::min(subject.submit[i], milliseconds() - start);
        gl.Finish();
        subject.total[i] = std::min(subject.total[i], milliseconds() - start);
        const auto feedback = subject.culler.take_feedback();
        if (pass == 0 && feedback) subject.visible += feedback->visible;
      }
    }
  }

  Json rows = Json::array();
  std::fprintf(out, "%zu items\n", snapshot.size());
  for (const Subject& subject : subjects) {
    const double total = mean(subject.total), submit = mean(subject.submit);
    const double ratio = total / mean(subjects[0].total);  // relative to the geometry variant
    const double visible = double(subject.visible) / double(views.size());
    const std::string variant(name_of(subject.culler.variant()));
    const std::size_t bytes = subject.culler.bounds_memory_bytes();
    std::fprintf(out, "  %-8s %8.3f ms (%.2f), submission %8.3f ms, boxes %11zu bytes, %9.0f visible\n",
                 variant.c_str(), total, ratio, submit, bytes, visible);
    rows.push_back({{"variant", variant},
                    {"total_ms", total},
                    {"submit_ms", submit},
                    {"ratio", ratio},
                    {"box_bytes", bytes},
                    {"bytes", subject.culler.memory_bytes()},
                    {"visible", visible}});
  }
  return Json{{"items", snapshot.size()}, {"cullers", rows}};
}

core::Expected<int> run(const Options& o) {
  auto context = gl::Context::create_offscreen({.platform = o.platform});
  if (!context) return tl::unexpected(context.error());
  std::FILE* out = apps::table_stream(o.json);
  std::fprintf(out, "%s\n", renderer_line(*context).c_str());
  Json result = renderer_json(*context);
  result["plants"] = Json::array();
  std::vector<std::uint64_t> plants = o.items;
  if (plants.empty())
    for (const Platform& platform : kPlatforms) plants.push_back(platform.primitives());
  for (const std::uint64_t items : plants) {
    auto plant = measure(*context, items, o, out);
    if (!plant) return tl::unexpected(plant.error());
    result["plants"].push_back(std::move(*plant));
  }
  return finish(o.json, result);
}

void add_options(apps::CommandLine& line, Options& o) {
  line.add("--items", o.items, "Items of each made-up plant; without it 85291 265333 293335 691951")
      .in_range(1000u, 20'000'000u);
  line.add("--views", o.views, "Views along the orbit").in_range(1, 1000).shows_default();
  line.add("--passes", o.passes, "Of which the best counts").in_range(1, 1000).shows_default();
  apps::add_context_option(line, o.platform);
  apps::add_json_option(line, o.json);
  line.examples(
      "  sightline-bench gpu-cull\n"
      "  sightline-bench gpu-cull --items 1000000 --passes 9 --json gpu.json");
}

}  // namespace
}  // namespace sightline::bench::gpu_cull_bench

sightline::bench::Run sightline::bench::add_gpu_cull(apps::CommandLine& line) {
  using namespace gpu_cull_bench;
  return add_subcommand<Options>(line, add_options, run);
}
