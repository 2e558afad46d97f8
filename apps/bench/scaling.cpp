// sightline-bench scaling: how stages that use several threads scale, on a model or a generated plant.
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "sightline/apps/bench/harness.h"
#include "sightline/apps/bench/stages.h"
#include "sightline/apps/bench/subcommands.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/need.h"
#include "sightline/culling/frustum/cpu_culler.h"
#include "sightline/raytrace/exact_visibility.h"

namespace sightline::bench::scaling_bench {
namespace {

using apps::need;

constexpr int kViews = 64, kWidth = 640, kHeight = 360;

void add_options(apps::CommandLine& line, StageOptions& o) {
  add_stage_options(line, o);
  line.examples(
      "  sightline-bench scaling --items 1000000\n"
      "  sightline-bench scaling a.rvm b.rvm c.rvm --threads 8 --json scaling.json");
}

TimedStage reading(const StageOptions& options) {
  return {"read " + std::to_string(options.model.files.size()) + " files", [&options](int threads) {
            importers::ImportOptions import = options.model.import;
            import.threads = threads;
            const std::vector<std::filesystem::path> paths(options.model.files.begin(), options.model.files.end());
            core::Scene scene;
            need(importers::import_files(paths, scene, scene.root(), import));
          }};
}

core::Expected<int> run(const StageOptions& options) {
  const std::unique_ptr<core::Scene> scene = need(model_or_plant(options.model, options.items));
  const core::Snapshot snapshot(*scene);
  const culling::CpuCuller culler(snapshot.bounds());
  const auto views = need(tour_views(snapshot, kViews, double(kWidth) / kHeight));
  const raytrace::Tracer tracer = need(raytrace::Tracer::create(snapshot));

  std::vector<TimedStage> stages;
  if (options.model.files.size() > 1) stages.push_back(reading(options));
  stages.push_back({"build the snapshot", [&](int threads) { const core::Snapshot made(*scene, threads); }});
  std::vector<core::VisibleSet> sets(views.size());
  std::map<int, core::ThreadPool> helpers;
  stages.push_back({"cull " + std::to_string(kViews) + " views", [&](int threads) {
                      culler.cull(views, sets, &helpers.try_emplace(threads, threads).first->second);
                    }});
  stages.push_back({"build the ray tracer", [&](int threads) { need(raytrace::Tracer::create(snapshot, threads)); }});
  stages.push_back({"exact visible set", [&](int threads) {
                      need(raytrace::ExactVisibility(tracer).compute(views.front(), kWidth, kHeight, 1, threads));
                    }});
  return report_stages(stages, snapshot.size(), options);
}

}  // namespace
}  // namespace sightline::bench::scaling_bench

sightline::bench::Run sightline::bench::add_scaling(apps::CommandLine& line) {
  using namespace scaling_bench;
  return add_subcommand<StageOptions>(line, add_options, run);
}
