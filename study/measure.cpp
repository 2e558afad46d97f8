#include "sightline/study/measure.h"

#include <algorithm>
#include <chrono>
#include <numeric>

#include "sightline/study/brute_force.h"

namespace sightline::study {
namespace {

double seconds_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

void add(const Errors& e, Errors& sum) {
  sum.visible += e.visible;
  sum.extra += e.extra;
  sum.missing += e.missing;
  sum.false_positives += e.false_positives;
  sum.false_negatives += e.false_negatives;
}

/// `cull(view)` is timed; `count()` and `ids()` tell what it found.
template <class Cull, class Count, class Ids>
void fly(const Model& model, int passes, Run& run, const Cull& cull, const Count& count, const Ids& ids) {
  const std::size_t frames = model.views.size();
  std::vector<std::vector<double>> times(frames);
  std::size_t sample = 0;
  for (int pass = 0; pass < passes; ++pass) {
    for (std::size_t i = 0; i < frames; ++i) {
      const double start = seconds_now();
      cull(model.views[i]);
      times[i].push_back(1e3 * (seconds_now() - start));
      if (pass > 0) continue;
      run.visible.push_back(count());
      if (sample < model.sampled.size() && model.sampled[sample] == i)
        add(compare(ids(), model.exact[sample++]), run.errors);
    }
  }
  run.samples = sample;
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
  sampled.clear();
  exact.clear();
  samples = std::min(samples, views.size());
  for (std::size_t i = 0; i < samples; ++i) {
    sampled.push_back((2 * i + 1) * views.size() / (2 * samples));
    exact.emplace_back(boxes, views[sampled.back()]);
  }
}

const Tree& Model::tree(TreeKind kind) const {
  return kind == TreeKind::kMean ? mean : kind == TreeKind::kMedian ? median : sah;
}

Run measure(const Model& model, const Variant& variant, int passes) {
  Culler culler(variant, model.boxes, model.tree(variant.tree));
  Run run;
  run.variant = name(variant);
  run.promise = promise(variant);
  run.memory_bytes = culler.memory_bytes();
  Visible visible;
  double nodes = 0.0, boxes = 0.0;
  fly(
      model, passes, run, [&](const core::View& view) { culler.cull(view, visible); },
      [&] {
        nodes += double(visible.counters.nodes_tested);
        boxes += double(visible.counters.boxes_tested);
        return visible.count();
      },
      [&] { return culler.ids(visible); });
  if (!run.ms.empty()) {
    run.mean_nodes = nodes / double(run.ms.size());
    run.mean_boxes = boxes / double(run.ms.size());
  }
  return run;
}

Run measure_brute_force(const Model& model, int passes) {
  BruteForce brute(model.boxes);
  Run run;
  run.variant = BruteForce::name();
  run.has_promise = false;
  run.memory_bytes = brute.memory_bytes();
  run.mean_boxes = double(model.boxes.size());
  fly(
      model, passes, run, [&](const core::View& view) { brute.cull(view); }, [&] { return brute.ids().size(); },
      [&] { return brute.ids(); });
  return run;
}

}  // namespace sightline::study
