#include "sightline/study/session.h"

#include <chrono>
#include <limits>

namespace sightline::study {
namespace {

class Session {
 public:
  Session(const Model& model, int passes, const std::function<void(const std::string&)>& progress)
      : passes_(passes), progress_(progress) {
    results_.model = &model;
  }

  Results run() {
    without_tree();
    trees_and_walks();
    flags();
    tests_on_trees();
    depths();
    threads();
    const Variant production{.tree = TreeKind::kWide};
    const auto start = std::chrono::steady_clock::now();
    { const Culler built(production, results_.model->boxes, {}); }
    results_.production_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    add(production);
    results_.runs.push_back(measure_brute_force(*results_.model, passes_));
    return std::move(results_);
  }

 private:
  /// Valid until the next one.
  const Run& add(const Variant& v) {
    if (const Run* done = results_.find(v)) return *done;
    progress_(name(v));
    results_.runs.push_back(measure(*results_.model, v, passes_));
    return results_.runs.back();
  }

  void without_tree() {
    for (const Test test : {Test::kCorners, Test::kRadar, Test::kRadarTwoAnswers, Test::kRadarByLimit, Test::kVertices,
                            Test::kSplit, Test::kSphere})
      add({.test = test});
    add({.test = Test::kSplit, .simd = Simd::kPerTest});
    add({.simd = Simd::kPerTest});
    add({.simd = Simd::kOverBoxes});
    for (const unsigned f : {1u, 2u, 8u, 16u}) add(with_flags({}, f));
  }

  void trees_and_walks() {
    for (const TreeKind tree : {TreeKind::kMean, TreeKind::kMedian, TreeKind::kSah})
      for (const Traversal traversal : {Traversal::kStack, Traversal::kStackless, Traversal::kCompact})
        add(on_tree(tree, traversal));
    const double mean = results_.find(on_tree(TreeKind::kMean))->fastest_ms;
    const double median = results_.find(on_tree(TreeKind::kMedian))->fastest_ms;
    results_.best_tree = mean <= median ? TreeKind::kMean : TreeKind::kMedian;
  }

  void flags() {
    double best = std::numeric_limits<double>::infinity();
    for (unsigned f = 0; f < 32; ++f) {
      const Run& r = add(with_flags(on_tree(results_.best_tree), f));
      if (r.fastest_ms >= best) continue;
      best = r.fastest_ms;
      results_.best_flags = r.variant;
    }
  }

  void tests_on_trees() {
    for (const TreeKind tree : {results_.best_tree, TreeKind::kSah}) {
      Variant v{.tree = tree};
      add(v);
      v.masking = true;
      add(v);
      v.plane_coherency = true;
      add(v);
    }
    for (const Test test : {Test::kCorners, Test::kRadar, Test::kRadarByLimit, Test::kSplit, Test::kSphere})
      add({.tree = results_.best_tree, .test = test});
    Variant v{.tree = results_.best_tree, .test = Test::kSplit, .simd = Simd::kPerTest};
    add(v);
    v.masking = true;
    add(v);
    v.tree = TreeKind::kSah;
    add(v);
    add({.tree = results_.best_tree, .simd = Simd::kPerTest});
  }

  void depths() {
    for (const std::uint32_t depth : {4u, 6u, 8u, 10u, 12u, 14u, 16u})
      for (const TreeKind tree : {results_.best_tree, TreeKind::kSah})
        add({.tree = tree, .masking = true, .test_items = false, .max_depth = depth});
  }

  void threads() {
    for (const Threads scheme : {Threads::kStatic, Threads::kTasks, Threads::kRing})
      for (const int count : {1, 2, 4})
        add({.tree = results_.best_tree, .test_items = false, .threads = scheme, .thread_count = count});
  }

  Results results_;
  int passes_;
  const std::function<void(const std::string&)>& progress_;
};

}  // namespace

Variant on_tree(TreeKind tree, Traversal traversal) {
  return {.tree = tree, .traversal = traversal, .test_items = false};
}

Variant with_flags(Variant v, unsigned flags) {
  v.plane_coherency = (flags & 1) != 0;
  v.octant = (flags & 2) != 0;
  v.masking = (flags & 4) != 0;
  v.motion = (flags & 8) != 0;
  v.pre_test = (flags & 16) != 0;
  return v;
}

const Run* Results::find(const std::string& variant) const {
  for (const Run& r : runs)
    if (r.variant == variant) return &r;
  return nullptr;
}

Results run_everything(const Model& model, int passes, const std::function<void(const std::string&)>& progress) {
  return Session(model, passes, progress).run();
}

}  // namespace sightline::study
