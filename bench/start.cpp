// sightline-bench start: from a model file, or from its scene cache, to the first cull.
//
// One start per process, since memory that was used once is not new again. Steps: import (with --cache the cache), the
// commit, the snapshot, the view of the whole, the hidden ends at joints, the hierarchy and one cull. Times are elapsed
// ones and, since other programs may run beside, those of the processors. Memory is what the process then has in RAM:
// its own pages, and pages of files, which the system takes back when it needs them.

#include <cstdio>
#include <fstream>
#include <string>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "sightline/apps/common/cli.h"
#include "sightline/apps/common/model.h"
#include "sightline/bench/harness.h"
#include "sightline/bench/subcommands.h"
#include "sightline/core/snapshot.h"
#include "sightline/culling/cpu_culler.h"
#include "sightline/gpuprims/internal/joints.h"
#include "sightline/importers/import.h"

namespace sightline::bench {
namespace {

struct Options {
  std::string file, json;
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
  const nlohmann::json& json() const { return json_; }

 private:
  nlohmann::json json_ = nlohmann::json::array();
  double at_ = milliseconds(), used_ = processor_milliseconds();
};

core::Expected<int> run(const Options& options) {
  const double begin = milliseconds();
  Steps steps;
  core::Scene scene;
  const std::filesystem::path file = options.file;
  const auto report = importers::import_files(std::span(&file, 1), scene, scene.root(), options.import);
  if (!report) return tl::unexpected(report.error());
  apps::print_warnings(report->warnings);
  steps.done("import");
  if (auto delta = scene.commit(); !delta) return tl::unexpected(delta.error());
  steps.done("commit");
  const core::Snapshot snapshot(scene);
  steps.done("snapshot");
  const auto view =
      core::View::fit(snapshot.bounds().fitted_bounds().bounds, core::kOverviewDirection, apps::kFovy, 1.5);
  if (!view) return tl::unexpected(view.error());
  steps.done("view of the whole");
  const gpuprims::Joints joints(snapshot);
  steps.done("joints");
  culling::CpuCuller culler(snapshot.bounds());
  core::VisibleSet visible;
  culler.cull(*view, visible);
  steps.done("hierarchy, first cull");
  const double total = milliseconds() - begin;
  const double items = double(std::max<std::size_t>(scene.item_count(), 1));
  const nlohmann::json json = {{"file", options.file},
                               {"from_cache", report->from_cache},
                               {"items", scene.item_count()},
                               {"visible", snapshot.count(visible)},
                               {"covered_ends", joints.count()},
                               {"ms", total},
                               {"steps", steps.json()},
                               {"scene_bytes_per_item", double(scene.memory_bytes()) / items},
                               {"snapshot_bytes_per_item", double(snapshot.memory_bytes()) / items},
                               {"own_bytes", status_bytes("RssAnon")},
                               {"file_bytes", status_bytes("RssFile")}};
  return finish(options.json, json, [&](const nlohmann::json&, std::FILE* out) {
    for (const auto& step : steps.json())
      std::fprintf(out, "%-24s %9.1f ms %9.1f ms of processors\n", step["step"].get<std::string>().c_str(),
                   step["ms"].get<double>(), step["processor_ms"].get<double>());
    std::fprintf(out, "%-24s %9.1f ms%s\n", "all", total, report->from_cache ? ", from the cache" : "");
    std::fprintf(out, "%-24s %9zu, %llu visible\n", "items", scene.item_count(),
                 (unsigned long long)snapshot.count(visible));
    std::fprintf(out, "%-24s %9.1f scene, %.1f snapshot\n", "bytes per item", double(scene.memory_bytes()) / items,
                 double(snapshot.memory_bytes()) / items);
    std::fprintf(out, "%-24s %9.1f own, %.1f of files\n", "in RAM, bytes per item", status_bytes("RssAnon") / items,
                 status_bytes("RssFile") / items);
  });
}

void add_options(CLI::App& app, Options& options) {
  app.add_option("FILE", options.file, "Model file, or scene cache")->required();
  apps::add_import_options(app, options.import);
  apps::add_json_option(app, options.json);
  apps::add_examples(app,
                     "  sightline-bench start plant.rvm\n  sightline-bench start plant.slc\n"
                     "  sightline-bench start plant.rvm --cache caches");
}

}  // namespace

Run add_start(CLI::App& app) {
  return add_subcommand<Options>(app, add_options, run);
}

}  // namespace sightline::bench
