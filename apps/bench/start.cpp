// sightline-bench start: from a model file, or from its scene cache, to the first cull, and to the first image.
//
// One start per process, since memory that was used once is not new again. Steps: import (with --cache the cache), the
// commit, the snapshot, the view of the whole, the internal end caps at joints, the hierarchy and one cull; with --size
// an engine and its first image. With --memory a cache is drawn page by page: it is opened, the engine is made, the
// first image shows placeholders for what is missing, and the last step is the complete image. Times are elapsed ones
// and, since other programs may run beside, those of the processors. Memory is what the process then has in RAM: its
// own pages, and pages of files, which the system takes back when it needs them.

#include <cstdio>
#include <fstream>
#include <string>

#include "sightline/apps/bench/harness.h"
#include "sightline/apps/bench/subcommands.h"
#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/model.h"
#include "sightline/apps/common/need.h"
#include "sightline/apps/common/table.h"
#include "sightline/core/snapshot.h"
#include "sightline/culling/frustum/cpu_culler.h"
#include "sightline/gpuprims/internal/joints.h"
#include "sightline/importers/import.h"
#include "sightline/importers/json/internal/json.h"
#if SIGHTLINE_HAS_GL
#include "sightline/apps/common/paged_model.h"
#include "sightline/core/internal/platform/memory.h"
#include "sightline/engine/engine.h"
#include "sightline/render/image/image.h"
#endif

namespace sightline::bench::start_bench {
namespace {

using apps::need;

struct Options {
  std::string file, size, memory, json;
  importers::ImportOptions import;
};

/// A row of /proc/self/status in bytes; 0 where there is none.
double status_bytes(const std::string& name) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with(name + ":")) return std::stod(line.substr(name.size() + 1)) * 1024.0;
  return 0.0;
}

class Steps {
 public:
  void done(const char* name) {
    const double now = milliseconds(), used = processor_milliseconds();
    json_.push_back({{"step", name}, {"ms", now - at_}, {"processor_ms", used - used_}});
    at_ = now, used_ = used;
  }
  const sightline::json::Value& json() const { return json_; }

 private:
  sightline::json::Value json_ = sightline::json::Value::array();
  double at_ = milliseconds(), used_ = processor_milliseconds();
};

constexpr apps::Column kColumns[] = {
    {"step", "step"}, {"ms", "ms", "{:.1f}"}, {"ms of processors", "processor_ms", "{:.1f}"}};
constexpr double kAspect = 1.5;  // where no image is drawn

/// The view of the whole, of `size` where one was given.
core::View overview(const core::FittedBounds& fitted, const std::array<int, 2>& size) {
  const double aspect = size[0] > 0 ? double(size[0]) / size[1] : kAspect;
  return need(core::View::fit(fitted.bounds, core::kOverviewDirection, apps::kFovy, aspect));
}

core::Expected<int> report(const Options& options, json::Value json, const json::Value& steps) {
  json["file"] = options.file;
  json["steps"] = steps;
  double total = 0.0;
  for (const auto& step : steps) total += step["ms"].get<double>();
  json["ms"] = total;
  json.update({{"own_bytes", status_bytes("RssAnon")}, {"file_bytes", status_bytes("RssFile")}});
  return finish(options.json, json::sorted(std::move(json)), [&](const json::Value& all, std::FILE* out) {
    apps::print_table(steps, kColumns, out);
    std::fprintf(out, "\n");
    std::fprintf(out, "%-24s %9.1f ms%s\n", "all", total, all.value("from_cache", false) ? ", from the cache" : "");
    const double items = std::max(all["items"].get<double>(), 1.0);
    std::fprintf(out, "%-24s %9.0f, %.0f visible\n", "items", all["items"].get<double>(), all["visible"].get<double>());
    if (all.contains("snapshot_bytes_per_item"))
      std::fprintf(out, "%-24s %9.1f scene, %.1f snapshot\n", "bytes per item",
                   all["scene_bytes_per_item"].get<double>(), all["snapshot_bytes_per_item"].get<double>());
    std::fprintf(out, "%-24s %9.1f own, %.1f of files\n", "in RAM, bytes per item",
                 all["own_bytes"].get<double>() / items, all["file_bytes"].get<double>() / items);
  });
}

#if SIGHTLINE_HAS_GL
core::Expected<int> run_paged(const Options& options, const std::array<int, 2>& size) {
  Steps steps;
  apps::ModelOptions model;
  model.files = {options.file};
  auto engine = need(apps::open_paged(model, options.memory, {.width = size[0], .height = size[1]}));
  const core::View view = overview(engine.scene().fitted, size);
  steps.done("opening, engine");
  const auto first = need(engine.frame(view));
  (void)engine.read_colour();
  steps.done("first image");
  const auto last = need(engine.settle(view));
  (void)engine.read_colour();
  steps.done("complete image");
  need(apps::page_errors(engine));
  return report(options,
                {{"items", engine.scene().items},
                 {"visible", last.items_drawn},
                 {"first_placeholders", first.placeholders},
                 {"pages", last.loaded},
                 {"peak_bytes", core::platform::peak_memory()}},
                steps.json());
}

void draw(core::Scene& scene, const core::View& view, const std::array<int, 2>& size, Steps& steps) {
  auto engine = need(engine::Engine::create(
      scene, {.draw = true, .width = size[0], .height = size[1], .culling = {.culler = engine::CullerChoice::kCpu}}));
  steps.done("engine");
  need(engine.frame(view));
  need(engine.read_colour());
  steps.done("first image");
}

#endif

core::Expected<int> run_in_memory(const Options& options, const std::array<int, 2>& size) {
  Steps steps;
  core::Scene scene;
  const std::filesystem::path file = options.file;
  const auto imported = need(importers::import_files(std::span(&file, 1), scene, scene.root(), options.import));
  apps::print_warnings(imported.warnings);
  steps.done("import");
  need(scene.commit());
  steps.done("commit");
  auto snapshot = std::make_unique<core::Snapshot>(scene);
  steps.done("snapshot");
  const core::View view = overview(snapshot->bounds().fitted_bounds(), size);
  steps.done("view of the whole");
  const double items = double(std::max<std::size_t>(scene.item_count(), 1));
  json::Value json = {{"from_cache", imported.from_cache}, {"items", scene.item_count()}};
  {
    const gpuprims::Joints joints(*snapshot);
    steps.done("joints");
    json["covered_ends"] = joints.count();
    culling::CpuCuller culler(snapshot->bounds());
    core::VisibleSet visible;
    culler.cull(view, visible);
    steps.done("hierarchy, first cull");
    json["visible"] = snapshot->count(visible);
    json["scene_bytes_per_item"] = double(scene.memory_bytes()) / items;
    json["snapshot_bytes_per_item"] = double(snapshot->memory_bytes()) / items;
  }
#if SIGHTLINE_HAS_GL
  snapshot.reset();  // the engine has its own
  if (size[0] > 0) draw(scene, view, size, steps);
#endif
  return report(options, json, steps.json());
}

core::Expected<int> run(const Options& options) {
  const auto size = options.size.empty() ? std::array<int, 2>{} : need(apps::parse_size(options.size));
#if SIGHTLINE_HAS_GL
  if (!options.memory.empty()) return run_paged(options, size);
#endif
  return run_in_memory(options, size);
}

void add_options(apps::CommandLine& line, Options& options) {
  apps::CommandLine general = line.group(apps::OptionGroup::kGeneral);
  general.add("FILE", options.file, "Model file, or scene cache").required();
  apps::add_import_options(line, options.import);
#if SIGHTLINE_HAS_GL
  const apps::Option size = general.add("--size", options.size, "Draw an image of so many pixels at the end")
                                .metavar("WxH")
                                .accepted_by(apps::parse_size);
  apps::add_memory_option(line, options.memory);
  line.option("--memory").needs(size);
#endif
  apps::add_json_option(line, options.json);
  line.examples(
      "  sightline-bench start plant.rvm\n  sightline-bench start plant.slc --size 640x360\n"
      "  sightline-bench start plant.rvm --cache caches\n"
      "  sightline-bench start huge --memory 1G --size 640x360");
}

}  // namespace
}  // namespace sightline::bench::start_bench

sightline::bench::Run sightline::bench::add_start(apps::CommandLine& line) {
  using namespace start_bench;
  return add_subcommand<Options>(line, add_options, run);
}
