#include "sightline/study/session.h"

#include <algorithm>
#include <limits>

#include "sightline/study/brute_force.h"
#include "sightline/study/peer.h"
#include "sightline/study/production.h"

namespace sightline::study {
namespace {

/// On one thread, with the set that an ideal plane test keeps but for rounding, or tighter.
bool contends(const Variant& v) {
  const Promise p = promise(v);
  return (p == Promise::kSame || p == Promise::kTighter) && v.threads == Threads::kOne && v.test_items && !v.octant &&
         v.max_depth == 0xff && v.test != Test::kSphere;
}

class Session {
 public:
  Session(const Model& model, const Path& path, const SessionOptions& options) : options_(options) {
    results_.model = &model;
    results_.path = &path;
  }

  Results everything() {
    without_tree();
    trees_and_walks();
    flags();
    tests_on_trees();
    depths();
    threads();
    others();
    return std::move(results_);
  }

  Results contenders(const Results& first, std::size_t count) {
    std::vector<std::pair<double, Variant>> by_time;
    for (std::size_t i = 0; i < first.variants.size(); ++i)
      if (contends(first.variants[i])) by_time.emplace_back(first.runs[i].fastest_ms, first.variants[i]);
    std::sort(by_time.begin(), by_time.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    if (by_time.size() > count) by_time.resize(count);
    for (const auto& [ms, variant] : by_time) add(variant);
    results_.best_tree = first.best_tree;
    results_.best_flags = first.best_flags;
    others();
    return std::move(results_);
  }

 private:
  bool wanted(const std::string& name) const {
    return options_.variants.empty() ||
           std::find(options_.variants.begin(), options_.variants.end(), name) != options_.variants.end();
  }

  /// Null when not wanted; valid until the next one.
  const Run* add(const Variant& v) {
    if (const Run* done = results_.find(v)) return done;
    if (!wanted(name(v))) return nullptr;
    options_.progress(name(v));
    results_.variants.push_back(v);
    results_.runs.push_back(measure(*results_.model, *results_.path, v, options_.passes));
    return &results_.runs.back();
  }

  void add(const std::string& name, Origin origin, const MakeMethod& make) {
    if (!wanted(name) && origin != Origin::kBaseline) return;
    options_.progress(name);
    results_.runs.push_back(measure(*results_.model, *results_.path, name, origin, make, options_.passes));
  }

  void others() {
    for (const ProductionForm& form : production_forms())
      add(form.name, Origin::kProduction, [&form](auto boxes) { return make_production(form, boxes); });
    for (const Peer& peer : peers()) add(peer.name, Origin::kPeer, peer.make);
    add(BruteForce::name(), Origin::kBaseline, [](auto boxes) { return std::make_unique<BruteForce>(boxes); });
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
    const Run* mean = results_.find(on_tree(TreeKind::kMean));
    const Run* median = results_.find(on_tree(TreeKind::kMedian));
    const bool by_median = median != nullptr && (mean == nullptr || median->fastest_ms < mean->fastest_ms);
    results_.best_tree = by_median ? TreeKind::kMedian : TreeKind::kMean;
  }

  void flags() {
    double best = std::numeric_limits<double>::infinity();
    for (unsigned f = 0; f < 32; ++f) {
      const Run* r = add(with_flags(on_tree(results_.best_tree), f));
      if (r == nullptr || r->fastest_ms >= best) continue;
      best = r->fastest_ms;
      results_.best_flags = r->variant;
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
  const SessionOptions& options_;
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

const Run* Results::fastest_exact() const {
  const Run* best = nullptr;
  for (std::size_t i = 0; i < variants.size(); ++i)
    if (contends(variants[i]) && (best == nullptr || runs[i].fastest_ms < best->fastest_ms)) best = &runs[i];
  return best;
}

Results run_everything(const Model& model, const SessionOptions& options) {
  return Session(model, model.paths.front(), options).everything();
}

Results run_contenders(const Results& first, const Path& path, std::size_t count, const SessionOptions& options) {
  return Session(*first.model, path, options).contenders(first, count);
}

}  // namespace sightline::study
