// The study's tables, as text.
#include <cstdio>
#include <string>

#include "sightline/study/operations.h"
#include "sightline/study/peer.h"
#include "sightline/study/production.h"
#include "sightline/study/tables/report.h"

namespace sightline::study {
namespace {

double fps(double ms) {
  return ms > 0.0 ? 1e3 / ms : 0.0;
}

void table_header(const char* title) {
  std::printf("\n%s\n", title);
  std::printf("%-44s %9s %9s %9s %9s %9s %9s %9s %9s %9s\n", "", "processed", "min fps", "max fps", "mean fps",
              "median ms", "fast. ms", "visible", "false +", "false -");
}

/// Rows as in the dissertation (frames processed in the path's seconds, fps), with visible counts and errors per
/// sampled frame.
void row(const Results& r, const Run* run) {
  if (run == nullptr) return;
  std::printf("%-44s %9.0f %9.1f %9.1f %9.1f %9.4f %9.4f %9.0f %9.1f %9.1f\n", run->variant.c_str(),
              r.path->seconds * fps(run->mean_ms), fps(run->max_ms), fps(run->min_ms), fps(run->mean_ms),
              run->median_ms, run->fastest_ms, run->mean_visible, run->false_positives(), run->false_negatives());
}
void common_rows(const Results& r) {
  for (const Run& run : r.runs)
    if (run.origin != Origin::kStudy) row(r, &run);
}

void print_operations(const Model& model) {
  const OperationTable table = count_operations(model.boxes, model.paths[0].views);
  std::printf("\nTable 4.1  float operations and comparisons, counted by running the tests (%s)\n", model.name.c_str());
  std::printf("%-28s %9s %9s %9s %9s\n", "", "update", "best", "worst", "mean");
  for (const auto& o : table)
    std::printf("%-28s %9llu %9llu %9llu %9.1f\n", o.name.c_str(), static_cast<unsigned long long>(o.update),
                static_cast<unsigned long long>(o.best), static_cast<unsigned long long>(o.worst), o.mean);
}

void print_trees(const std::vector<ModelResults>& all) {
  std::printf("\nTables 4.3, 4.4  hierarchies (leaves of at most 3 boxes of each kind; height in levels)\n");
  std::printf("%-10s %-14s %9s %9s %9s %7s %9s %9s\n", "", "", "objects", "nodes", "leaves", "height", "build s",
              "B/object");
  for (const ModelResults& paths : all) {
    const Results& r = paths.front();
    const Model& m = *r.model;
    const auto line = [&](const char* what, const Tree& t, double seconds) {
      std::printf("%-10s %-14s %9zu %9zu %9zu %7u %9.3f %9.1f\n", m.name.c_str(), what, m.boxes.size(), t.nodes.size(),
                  t.leaves, t.height, seconds, double(t.nodes.size()) * 48.0 / double(m.boxes.size()));
    };
    line("median", m.median, m.median_seconds);
    line("mean", m.mean, m.mean_seconds);
    line("SAH", m.sah, m.sah_seconds);
    line("median leaf 1", build_tree(m.boxes, {}, Split::kMedian, 1), 0.0);
    line("mean leaf 1", build_tree(m.boxes, {}, Split::kMean, 1), 0.0);
    for (const Run& run : r.runs)
      if (run.origin == Origin::kPeer || run.variant == "production")
        std::printf("%-10s %-14s %9zu %9s %9s %7s %9.3f %9.1f\n", m.name.c_str(), run.variant.c_str(), m.boxes.size(),
                    "", "", "", run.build_seconds, double(run.memory_bytes) / double(m.boxes.size()));
  }
}

void print_best(const std::vector<ModelResults>& all) {
  std::printf("\nTable 4.8  the best set of optimisations per model, of 32 on the better of mean and median\n");
  for (const ModelResults& paths : all) {
    const Results& r = paths.front();
    const Run *best = r.find(r.best_flags), *none = r.find(on_tree(r.best_tree));
    std::printf("%-10s %-52s %8.4f ms, x%.2f of none\n", r.model->name.c_str(), r.best_flags.c_str(), best->fastest_ms,
                none->fastest_ms / best->fastest_ms);
    for (unsigned f = 0; f < 32; ++f) row(r, r.find(with_flags(on_tree(r.best_tree), f)));
  }
}

/// What must be shown: nothing exact is faster than production.
void print_fastest(const std::vector<ModelResults>& all) {
  std::printf(
      "\nProduction against the fastest exact variant of the study, and everything else (ms a frame, fastest pass)\n");
  std::printf("%-10s %-7s %9s %10s %10s %6s %6s", "", "path", "visible", "production", "variant", "ratio", "ids");
  for (const Peer& peer : peers()) std::printf(" %14s", peer.name);
  std::printf(" %8s  fastest exact variant\n", "B");
  for (const ModelResults& paths : all) {
    for (const Results& r : paths) {
      const Run *production = r.production(), *ids = r.find("production ids"), *best = r.fastest_exact();
      if (production == nullptr || ids == nullptr || best == nullptr) continue;
      const auto ratio = [production](const Run& run) { return run.fastest_ms / production->fastest_ms; };
      std::printf("%-10s %-7s %9.0f %10.5f %10.5f %6.2f %6.2f", r.model->name.c_str(), r.path->name.c_str(),
                  production->mean_visible, production->fastest_ms, best->fastest_ms, ratio(*best), ratio(*ids));
      for (const Peer& peer : peers())
        if (const Run* run = r.find(peer.name)) std::printf(" %14.1f", ratio(*run));
      std::printf(" %8.2f  %s\n", ratio(r.brute_force()), best->variant.c_str());
    }
  }
}

}  // namespace

void print_tables(const std::vector<ModelResults>& all) {
  print_operations(*all.back().front().model);
  for (const ModelResults& paths : all) {
    const Results& r = paths.front();
    table_header(("Table 4.2  without hierarchy: " + r.model->name).c_str());
    for (const Test t : {Test::kRadarTwoAnswers, Test::kRadar, Test::kRadarByLimit, Test::kVertices, Test::kCorners,
                         Test::kSplit, Test::kSphere})
      row(r, r.find({.test = t}));
    for (const unsigned f : {1u, 2u, 8u, 16u}) row(r, r.find(with_flags({}, f)));
    common_rows(r);
  }
  print_trees(all);
  for (const ModelResults& paths : all) {
    const Results& r = paths.front();
    table_header(("Tables 4.5, 4.6  mean and median, and walks: " + r.model->name).c_str());
    for (const TreeKind tree : {TreeKind::kMedian, TreeKind::kMean, TreeKind::kSah})
      for (const auto t : {study::Traversal::kStack, study::Traversal::kStackless, study::Traversal::kCompact})
        row(r, r.find(on_tree(tree, t)));
    common_rows(r);
  }
  print_best(all);
  for (const ModelResults& paths : all) {
    const Results& r = paths.front();
    table_header(("Table 4.9  SIMD: " + r.model->name).c_str());
    for (const Variant& v :
         {Variant{}, Variant{.simd = Simd::kPerTest}, Variant{.simd = Simd::kOverBoxes}, Variant{.test = Test::kSplit},
          Variant{.test = Test::kSplit, .simd = Simd::kPerTest}, Variant{.tree = r.best_tree},
          Variant{.tree = r.best_tree, .simd = Simd::kPerTest}, Variant{.tree = r.best_tree, .test = Test::kSplit},
          Variant{.tree = r.best_tree, .test = Test::kSplit, .simd = Simd::kPerTest}})
      row(r, r.find(v));
    common_rows(r);
  }
  for (const ModelResults& paths : all) {
    const Results& r = paths.front();
    table_header(("Figures 4.13 to 4.16  threads, limited depth, other tests on trees: " + r.model->name).c_str());
    for (const Run& run : r.runs)
      if (run.variant.find(" x") != std::string::npos || run.variant.find("depth<=") != std::string::npos ||
          run.variant.find("whole-leaves") == std::string::npos)
        row(r, &run);  // production and peers are among them
  }
  print_fastest(all);
}

void print_runs(const std::vector<ModelResults>& all) {
  for (const ModelResults& paths : all) {
    for (const Results& r : paths) {
      table_header((r.model->name + ", " + r.path->name).c_str());
      for (const Run& run : r.runs) row(r, &run);
    }
  }
}

}  // namespace sightline::study
