// sightline-bench scaling: how stages that use several threads scale, on a model or a generated plant.
//
// Each stage runs with 1, 2, 4 … threads, interleaved; the least wall time counts, with the processor time of that
// pass. Amdahl's law, T(n) = T(1) (s + (1 - s) / n), is fitted by least squares over all n: s is the serial share. From
// it follows what more processors would bring at best. (G. M. Amdahl, "Validity of the single processor approach to
// achieving large scale computing capabilities", 1967.) Processor time that grows with the threads is what they wait
// for one another or for memory; the fit counts that as serial, too.
#include <algorithm>
#include <cstdio>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "sightline/apps/bench/harness.h"
#include "sightline/apps/bench/subcommands.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/need.h"
#include "sightline/culling/frustum/cpu_culler.h"
#include "sightline/importers/json/internal/json.h"
#include "sightline/raytrace/exact_visibility.h"

namespace sightline::bench::scaling_bench {
namespace {

using apps::need;
using Json = json::Value;

struct Options {
  apps::ModelOptions model;
  std::uint64_t items = 1'000'000;
  int threads = 0, passes = 5;
  std::string json;
};

constexpr int kViews = 64, kWidth = 640, kHeight = 360;
constexpr int kForetold[] = {4, 8, 16, 64};

void add_options(apps::CommandLine& line, Options& o) {
  apps::add_model_options(line, o.model);
  line.option("MODEL").required(false);
  line.add("--items", o.items, "Without MODEL: items of a generated plant")
      .in_range(std::uint64_t(1'000), std::uint64_t(100'000'000))
      .shows_default();
  line.add("--threads", o.threads, "The most threads; 0: one per processor")
      .in_range(0, core::ThreadPool::kMost)
      .shows_default();
  line.add("--passes", o.passes, "Of each stage with each number of threads; the least counts")
      .in_range(1, 1000)
      .shows_default();
  apps::add_json_option(line, o.json);
  line.examples(
      "  sightline-bench scaling --items 1000000\n"
      "  sightline-bench scaling a.rvm b.rvm c.rvm --threads 8 --json scaling.json");
}

/// Something that `run` does with a number of threads.
struct Stage {
  std::string name;
  std::function<void(int threads)> run;
};

struct Timed {
  int threads = 1;
  double wall = std::numeric_limits<double>::infinity(), processor = 0.0;  // ms
};

/// The serial share by which Amdahl's law comes nearest to the times, from 0 to 1. The first is of one thread.
double serial_share(const std::vector<Timed>& times) {
  double product = 0.0, square = 0.0;
  for (const Timed& t : times) {
    const double parallel = 1.0 - 1.0 / t.threads, above_ideal = t.wall / times[0].wall - 1.0 / t.threads;
    product += parallel * above_ideal;
    square += parallel * parallel;
  }
  return square > 0.0 ? std::clamp(product / square, 0.0, 1.0) : 1.0;
}

Json measure(const Stage& stage, const std::vector<int>& counts, int passes) {
  std::vector<Timed> times;
  for (const int threads : counts) times.push_back({.threads = threads});
  for (int pass = 0; pass < passes; ++pass)
    for (Timed& t : times) {
      const double start = milliseconds(), processor = processor_milliseconds();
      stage.run(t.threads);
      const double wall = milliseconds() - start;
      if (wall >= t.wall) continue;
      t.wall = wall;
      t.processor = processor_milliseconds() - processor;
    }
  const double serial = serial_share(times);
  Json row{{"stage", stage.name}, {"serial_share", serial}};
  for (const Timed& t : times)
    row["threads"].push_back({{"count", t.threads}, {"wall_ms", t.wall}, {"processor_ms", t.processor}});
  for (const int n : kForetold)
    row["foretold"].push_back({{"processors", n}, {"speedup", 1.0 / (serial + (1.0 - serial) / n)}});
  return row;
}

void print_table(const Json& json, std::FILE* out) {
  std::fprintf(out, "%zu items, wall ms (processor ms)\n%-28s", json["items"].get<std::size_t>(), "stage");
  for (const Json& t : json["stages"][0]["threads"])
    std::fprintf(out, " %12d thread%s", t["count"].get<int>(), t["count"].get<int>() > 1 ? "s" : " ");
  std::fprintf(out, "   serial");
  for (const int n : kForetold) std::fprintf(out, "  at %2d", n);
  for (const Json& row : json["stages"]) {
    std::fprintf(out, "\n%-28s", row["stage"].get<std::string>().c_str());
    for (const Json& t : row["threads"])
      std::fprintf(out, " %9.2f (%8.2f)", t["wall_ms"].get<double>(), t["processor_ms"].get<double>());
    std::fprintf(out, "   %5.1f%%", 100.0 * row["serial_share"].get<double>());
    for (const Json& f : row["foretold"]) std::fprintf(out, " %5.1fx", f["speedup"].get<double>());
  }
  std::fprintf(out, "\n");
}

Stage reading(const Options& options) {
  return {"read " + std::to_string(options.model.files.size()) + " files", [&options](int threads) {
            importers::ImportOptions import = options.model.import;
            import.threads = threads;
            const std::vector<std::filesystem::path> paths(options.model.files.begin(), options.model.files.end());
            core::Scene scene;
            need(importers::import_files(paths, scene, scene.root(), import));
          }};
}

core::Expected<int> run(const Options& options) {
  const std::unique_ptr<core::Scene> scene = need(model_or_plant(options.model, options.items));
  const core::Snapshot snapshot(*scene);
  const culling::CpuCuller culler(snapshot.bounds());
  const auto views = need(tour_views(snapshot, kViews, double(kWidth) / kHeight));
  const raytrace::Tracer tracer = need(raytrace::Tracer::create(snapshot));

  std::vector<Stage> stages;
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

  const int most = options.threads > 0 ? options.threads : int(std::max(1u, std::thread::hardware_concurrency()));
  std::vector<int> counts;
  for (int n = 1; n < most; n *= 2) counts.push_back(n);
  counts.push_back(most);
  Json json{{"items", snapshot.size()}};
  for (const Stage& stage : stages) json["stages"].push_back(measure(stage, counts, options.passes));
  return finish(options.json, json, print_table);
}

}  // namespace
}  // namespace sightline::bench::scaling_bench

sightline::bench::Run sightline::bench::add_scaling(apps::CommandLine& line) {
  using namespace scaling_bench;
  return add_subcommand<Options>(line, add_options, run);
}
