#include "sightline/study/measure.h"

#include <algorithm>
#include <chrono>
#include <numeric>

#if __has_include(<valgrind/callgrind.h>)
#include <valgrind/callgrind.h>
#define SIGHTLINE_STUDY_CALLGRIND 1
#endif

namespace sightline::study {
namespace {

double seconds_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// The instructions between on() and off() are counted, when callgrind looks on; nothing happens otherwise.
class InstructionCounter {
 public:
#ifdef SIGHTLINE_STUDY_CALLGRIND
  explicit InstructionCounter(const std::string& name) : name_(name) {
    CALLGRIND_START_INSTRUMENTATION;
    CALLGRIND_ZERO_STATS;  // stopping forgets the sum, but not where the last dump ended
  }
  ~InstructionCounter() {
    CALLGRIND_DUMP_STATS_AT(name_.c_str());
    CALLGRIND_STOP_INSTRUMENTATION;
  }
  void on() {
    CALLGRIND_TOGGLE_COLLECT;
  }
  void off() {
    CALLGRIND_TOGGLE_COLLECT;
  }

 private:
  std::string name_;
#else
  explicit InstructionCounter(const std::string&) {}
  void on() {}
  void off() {}
#endif
};

void add(const Errors& e, Errors& sum) {
  sum.visible += e.visible;
  sum.extra += e.extra;
  sum.missing += e.missing;
  sum.false_positives += e.false_positives;
  sum.false_negatives += e.false_negatives;
}

void add(const core::CullCounters& c, core::CullCounters& sum) {
  sum.nodes_tested += c.nodes_tested;
  sum.boxes_tested += c.boxes_tested;
}

void set_counters(const core::CullCounters& sums, Run& run) {
  const double frames = double(std::max<std::size_t>(1, run.visible.size()));
  run.mean_nodes = double(sums.nodes_tested) / frames;
  run.mean_boxes = double(sums.boxes_tested) / frames;
}

/// One pass. `cull(view)` is timed; in the first pass `count()` and `ids()` tell what it found.
template <class Cull, class Count, class Ids>
void fly(const Path& path, std::vector<std::vector<double>>& times, Run& run, const Cull& cull, const Count& count,
         const Ids& ids) {
  const bool first = times.empty();
  times.resize(path.views.size());
  InstructionCounter instructions(run.variant);
  for (std::size_t i = 0; i < path.views.size(); ++i) {
    instructions.on();
    const double start = seconds_now();
    cull(path.views[i]);
    times[i].push_back(1e3 * (seconds_now() - start));
    instructions.off();
    if (!first) continue;
    run.visible.push_back(count());
    if (run.samples < path.sampled.size() && path.sampled[run.samples] == i)
      add(compare(ids(), path.exact[run.samples++]), run.errors);
  }
}

/// `times`: of each frame, one a pass.
void summarise(std::vector<std::vector<double>> times, Run& run) {
  const std::size_t frames = times.size();
  for (auto& t : times) {
    run.fastest_ms += *std::min_element(t.begin(), t.end()) / double(frames);
    run.ms.push_back(median_of(std::move(t)));
  }
  if (frames == 0) return;
  run.mean_ms = std::accumulate(run.ms.begin(), run.ms.end(), 0.0) / double(frames);
  run.median_ms = median_of(run.ms);
  run.min_ms = *std::min_element(run.ms.begin(), run.ms.end());
  run.max_ms = *std::max_element(run.ms.begin(), run.ms.end());
  run.mean_visible = double(std::accumulate(run.visible.begin(), run.visible.end(), std::uint64_t(0))) / double(frames);
}

/// What Run has of a method in the making.
struct Flight {
  Run run;
  std::vector<std::vector<double>> times;
  core::CullCounters sums;
};

}  // namespace

double median_of(std::vector<double> values) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return n % 2 == 1 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
}

void Model::prepare(std::size_t samples) {
  const auto timed = [this](Split split, double& taken) {
    const double start = seconds_now();
    Tree built = build_tree(boxes, kinds, split);
    taken = seconds_now() - start;
    return built;
  };
  mean = timed(Split::kMean, mean_seconds);
  median = timed(Split::kMedian, median_seconds);
  sah = timed(Split::kSah, sah_seconds);
  for (Path& path : paths) {
    path.sampled.clear();
    path.exact.clear();
    const std::size_t count = std::min(samples, path.views.size());
    for (std::size_t i = 0; i < count; ++i) {
      path.sampled.push_back((2 * i + 1) * path.views.size() / (2 * count));
      path.exact.emplace_back(boxes, path.views[path.sampled.back()]);
    }
  }
}

const Tree& Model::tree(TreeKind kind) const {
  return kind == TreeKind::kMean ? mean : kind == TreeKind::kMedian ? median : sah;
}

Run measure(const Model& model, const Path& path, const Variant& variant, int passes) {
  Run run;
  run.variant = name(variant);
  run.promise = promise(variant);
  const double start = seconds_now();
  Culler culler(variant, model.boxes, model.tree(variant.tree));
  run.build_seconds = seconds_now() - start;
  run.memory_bytes = culler.memory_bytes();
  Visible visible;
  core::CullCounters sums;
  std::vector<std::vector<double>> times;
  for (int pass = 0; pass < passes; ++pass)
    fly(
        path, times, run, [&](const core::View& view) { culler.cull(view, visible); },
        [&] {
          add(visible.counters, sums);
          return visible.count();
        },
        [&] { return culler.ids(visible); });
  summarise(std::move(times), run);
  set_counters(sums, run);
  return run;
}

std::vector<Run> measure(const Path& path, std::span<const Contestant> contestants, int passes) {
  std::vector<Flight> flights(contestants.size());
  for (int pass = 0; pass < passes; ++pass) {
    for (std::size_t k = 0; k < contestants.size(); ++k) {
      Method& method = *contestants[k].method;
      Flight& flight = flights[k];
      flight.run.variant = contestants[k].name;
      fly(
          path, flight.times, flight.run, [&](const core::View& view) { method.cull(view); },
          [&] {
            add(method.counters(), flight.sums);
            return method.count();
          },
          [&] { return method.ids(); });
    }
  }
  std::vector<Run> runs;
  for (std::size_t k = 0; k < contestants.size(); ++k) {
    Run& run = flights[k].run;
    run.origin = contestants[k].origin;
    if (run.origin == Origin::kProduction) run.promise = Promise::kSame;
    run.build_seconds = contestants[k].build_seconds;
    run.memory_bytes = contestants[k].method->memory_bytes();
    summarise(std::move(flights[k].times), run);
    set_counters(flights[k].sums, run);
    runs.push_back(std::move(run));
  }
  return runs;
}

Run measure(const Model& model, const Path& path, const std::string& name, Origin origin, const MakeMethod& make,
            int passes) {
  const double start = seconds_now();
  Contestant contestant{name, origin, make(model.boxes), 0.0};
  contestant.build_seconds = seconds_now() - start;
  return std::move(measure(path, std::span(&contestant, 1), passes).front());
}

}  // namespace sightline::study
