#include "sightline/apps/study/measure.h"

#include <algorithm>
#include <numeric>

namespace sightline::study {
namespace {

void add(const Errors& e, Errors& sum) {
  sum.visible += e.visible;
  sum.extra += e.extra;
  sum.missing += e.missing;
  sum.false_positives += e.false_positives;
  sum.false_negatives += e.false_negatives;
}

/// A run in the making.
struct Flight {
  Run run;
  std::vector<std::vector<double>> times;  // of each frame, one a pass
};

void fly(const Path& path, Method& method, Flight& flight) {
  Run& run = flight.run;
  const bool first = flight.times.empty();
  flight.times.resize(path.views.size());
  for (std::size_t i = 0; i < path.views.size(); ++i) {
    const double start = bench::milliseconds();
    method.cull(path.views[i]);
    flight.times[i].push_back(bench::milliseconds() - start);
    if (!first) continue;
    run.visible.push_back(method.count());
    run.mean_nodes += double(method.counters().nodes_tested) / double(path.views.size());
    run.mean_boxes += double(method.counters().boxes_tested) / double(path.views.size());
    if (run.samples < path.sampled.size() && path.sampled[run.samples] == i)
      add(compare(method.ids(), path.exact[run.samples++]), run.errors);
  }
}

void summarise(const std::vector<std::vector<double>>& times, Run& run) {
  const double frames = double(times.size());
  for (const std::vector<double>& t : times) {
    run.fastest_ms += *std::min_element(t.begin(), t.end()) / frames;
    run.ms.push_back(apps::median(t));
  }
  if (times.empty()) return;
  const apps::Summary summary = apps::summarise(run.ms);
  run.mean_ms = summary.mean;
  run.median_ms = summary.median;
  run.max_ms = summary.max;
  run.min_ms = *std::min_element(run.ms.begin(), run.ms.end());
  run.mean_visible = double(std::accumulate(run.visible.begin(), run.visible.end(), std::uint64_t(0))) / frames;
}

}  // namespace

void Model::prepare(std::size_t samples) {
  const auto timed = [this](Split split, double& taken) {
    const double start = bench::milliseconds();
    Tree built = build_tree(boxes, kinds, split);
    taken = 1e-3 * (bench::milliseconds() - start);
    return built;
  };
  mean = timed(Split::kMean, mean_seconds);
  median = timed(Split::kMedian, median_seconds);
  path.sampled.clear();
  path.exact.clear();
  const std::size_t count = std::min(samples, path.views.size());
  for (std::size_t i = 0; i < count; ++i) {
    path.sampled.push_back((2 * i + 1) * path.views.size() / (2 * count));
    path.exact.emplace_back(boxes, path.views[path.sampled.back()]);
  }
}

std::vector<Run> measure(const Path& path, std::span<const Contestant> contestants, int passes) {
  std::vector<Flight> flights(contestants.size());
  for (int pass = 0; pass < passes; ++pass)
    for (std::size_t k = 0; k < contestants.size(); ++k) {
      flights[k].run.variant = contestants[k].name;
      fly(path, *contestants[k].method, flights[k]);
    }
  std::vector<Run> runs;
  for (std::size_t k = 0; k < contestants.size(); ++k) {
    Run& run = flights[k].run;
    run.origin = contestants[k].origin;
    run.promise = contestants[k].promise;
    run.build_seconds = contestants[k].build_seconds;
    run.memory_bytes = contestants[k].method->memory_bytes();
    summarise(flights[k].times, run);
    runs.push_back(std::move(run));
  }
  return runs;
}

}  // namespace sightline::study
