#include "sightline/apps/bench/stages.h"

#include <algorithm>
#include <limits>
#include <thread>

#include "sightline/apps/bench/harness.h"
#include "sightline/apps/bench/subcommand.h"
#include "sightline/core/thread_pool.h"

namespace sightline::bench {
namespace {

using Json = json::Value;

constexpr int kForetold[] = {4, 8, 16, 64};

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

Json measure(const TimedStage& stage, const std::vector<int>& counts, int passes) {
  std::vector<Timed> times;
  for (const int threads : counts) times.push_back({.threads = threads});
  for (int pass = 0; pass < passes; ++pass)
    for (Timed& t : times) {
      const double start = milliseconds(), processor = processor_milliseconds();
      stage.run(t.threads);
      const double wall = (milliseconds() - start) / stage.count;
      if (wall >= t.wall) continue;
      t.wall = wall;
      t.processor = (processor_milliseconds() - processor) / stage.count;
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

}  // namespace

void add_stage_options(apps::CommandLine& line, StageOptions& o) {
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
}

core::Expected<int> report_stages(std::span<const TimedStage> stages, std::size_t items, const StageOptions& options) {
  const int most = options.threads > 0 ? options.threads : int(std::max(1u, std::thread::hardware_concurrency()));
  std::vector<int> counts;
  for (int n = 1; n < most; n *= 2) counts.push_back(n);
  counts.push_back(most);
  Json json{{"items", items}};
  for (const TimedStage& stage : stages) json["stages"].push_back(measure(stage, counts, options.passes));
  return finish(options.json, json, print_table);
}

}  // namespace sightline::bench
