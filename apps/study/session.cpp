#include "sightline/apps/study/session.h"

#include <algorithm>
#include <limits>

#include "sightline/apps/bench/brute_force.h"
#include "sightline/apps/study/culler.h"
#include "sightline/apps/study/production.h"

namespace sightline::study {
namespace {

/// On one thread, with the set that an ideal plane test keeps but for rounding, or tighter.
bool contends(const Variant& v) {
  const Promise p = promise(v);
  return (p == Promise::kSame || p == Promise::kTighter) && v.threads == Threads::kOne && v.test_items &&
         !v.has(kOctant);
}

class Session {
 public:
  Session(const Model& model, const SessionOptions& options) : options_(options) { results_.model = &model; }

  Results run() {
    without_tree();
    trees_and_walks();
    flags();
    tests_on_trees();
    threads();
    others();
    return std::move(results_);
  }

 private:
  /// Null when not wanted; valid until the next one.
  const Run* add(const Variant& v) {
    if (const Run* done = results_.find(v)) return done;
    if (!options_.wants(name(v))) return nullptr;
    results_.variants.push_back(v);
    const Model& model = *results_.model;
    add(name(v), Origin::kStudy, promise(v),
        [&] { return std::make_unique<Culler>(v, model.boxes, model.tree(v.tree)); });
    return &results_.runs.back();
  }

  template <class Make>
  void add(const std::string& name, Origin origin, std::optional<Promise> promise, const Make& make) {
    if (!options_.wants(name) && origin != Origin::kBaseline) return;
    options_.progress(name);
    const auto contestant = Contestant::create(name, origin, promise, make);
    results_.runs.push_back(measure(results_.model->path, std::span(&*contestant, 1), options_.passes).front());
  }

  void others() {
    const std::vector<core::Aabb>& boxes = results_.model->boxes;
    for (const bool ids : {false, true})
      add(ids ? kProductionIds : kProduction, Origin::kProduction, Promise::kSame,
          [&] { return make_production(boxes, ids); });
    add(bench::BruteForce::name(), Origin::kBaseline, std::nullopt, [&] { return make_brute_force(boxes); });
  }

  void without_tree() {
    for (const Test test : {Test::kCorners, Test::kRadar, Test::kRadarTwoAnswers, Test::kVertices, Test::kSplit})
      add({.test = test});
    add({.test = Test::kSplit, .simd = true});
    add({.simd = true});
    for (const unsigned flag : {kPlaneCoherency, kOctant, kMotion, kPreTest}) add({.flags = flag});
  }

  void trees_and_walks() {
    for (const TreeKind tree : {TreeKind::kMean, TreeKind::kMedian})
      for (const Traversal traversal : {Traversal::kStack, Traversal::kStackless, Traversal::kCompact})
        add(on_tree(tree, 0, traversal));
    const Run* mean = results_.find(on_tree(TreeKind::kMean));
    const Run* median = results_.find(on_tree(TreeKind::kMedian));
    const bool by_median = median != nullptr && (mean == nullptr || median->fastest_ms < mean->fastest_ms);
    results_.best_tree = by_median ? TreeKind::kMedian : TreeKind::kMean;
  }

  void flags() {
    double best = std::numeric_limits<double>::infinity();
    for (unsigned flags = 0; flags <= kAllFlags; ++flags) {
      const Run* r = add(on_tree(results_.best_tree, flags));
      if (r == nullptr || r->fastest_ms >= best) continue;
      best = r->fastest_ms;
      results_.best_flags = r->variant;
    }
  }

  void tests_on_trees() {
    const TreeKind tree = results_.best_tree;
    for (const unsigned flags : {0u, unsigned(kMasking), kMasking | kPlaneCoherency})
      add({.tree = tree, .flags = flags});
    for (const Test test : {Test::kCorners, Test::kRadar, Test::kSplit}) add({.tree = tree, .test = test});
    for (const unsigned flags : {0u, unsigned(kMasking)})
      add({.tree = tree, .test = Test::kSplit, .simd = true, .flags = flags});
    add({.tree = tree, .simd = true});
  }

  void threads() {
    for (const Threads scheme : {Threads::kStatic, Threads::kTasks, Threads::kRing})
      for (const int count : {1, 2, 4})
        add({.tree = results_.best_tree, .test_items = false, .threads = scheme, .thread_count = count});
  }

  Results results_;
  const SessionOptions& options_;
};

}  // namespace

Variant on_tree(TreeKind tree, unsigned flags, Traversal traversal) {
  return {.tree = tree, .traversal = traversal, .flags = flags, .test_items = false};
}

bool SessionOptions::wants(const std::string& name) const {
  return variants.empty() || std::find(variants.begin(), variants.end(), name) != variants.end();
}

const Run* Results::find(const std::string& variant) const {
  for (const Run& r : runs)
    if (r.variant == variant) return &r;
  return nullptr;
}

const Run* Results::fastest_exact() const {
  const Run* best = nullptr;
  for (std::size_t i = 0; i < variants.size(); ++i)
    if (contends(variants[i]) && (best == nullptr || runs[i].fastest_ms < best->fastest_ms)) best = &runs[i];
  return best;
}

Results run_everything(const Model& model, const SessionOptions& options) {
  return Session(model, options).run();
}

}  // namespace sightline::study
