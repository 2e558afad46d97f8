#include "sightline/apps/study/tables/report.h"

#include <algorithm>
#include <map>

#include "sightline/apps/common/output.h"
#include "sightline/apps/common/svg_plot.h"
#include "sightline/apps/study/operations.h"

namespace sightline::study {
namespace {

double fps(double ms) {
  return ms > 0.0 ? 1e3 / ms : 0.0;
}

// --- tables ----------------------------------------------------------------------------------------------------------

class Printer {
 public:
  explicit Printer(std::FILE* out) : out_(out) {}

  void header(const std::string& title) const {
    std::fprintf(out_, "\n%s\n%-44s %9s %9s %9s %9s %9s %9s %9s %9s %9s\n", title.c_str(), "", "processed", "min fps",
                 "max fps", "mean fps", "median ms", "fast. ms", "visible", "false +", "false -");
  }

  /// Rows as in the dissertation (frames processed in the path's seconds, fps), with visible counts and errors per
  /// sampled frame.
  void row(const Results& r, const Run* run) const {
    if (run == nullptr) return;
    std::fprintf(out_, "%-44s %9.0f %9.1f %9.1f %9.1f %9.4f %9.4f %9.0f %9.1f %9.1f\n", run->variant.c_str(),
                 r.model->path.seconds * fps(run->mean_ms), fps(run->max_ms), fps(run->min_ms), fps(run->mean_ms),
                 run->median_ms, run->fastest_ms, run->mean_visible, run->false_positives(), run->false_negatives());
  }

  /// A table of some variants of each model, with production and brute force.
  template <class VariantsOf>
  void table(const std::vector<Results>& all, const std::string& title, const VariantsOf& variants_of) const {
    for (const Results& r : all) {
      header(title + ": " + r.model->name);
      for (const Variant& v : variants_of(r)) row(r, r.find(v));
      for (const Run& run : r.runs)
        if (run.origin != Origin::kStudy) row(r, &run);
    }
  }

  void operations(const Model& model) const {
    std::fprintf(out_, "\nTable 4.1  float operations and comparisons, counted by running the tests (%s)\n",
                 model.name.c_str());
    std::fprintf(out_, "%-28s %9s %9s %9s %9s\n", "", "update", "best", "worst", "mean");
    for (const Operations& o : count_operations(model.boxes, model.path.views))
      std::fprintf(out_, "%-28s %9llu %9llu %9llu %9.1f\n", o.name.c_str(), static_cast<unsigned long long>(o.update),
                   static_cast<unsigned long long>(o.best), static_cast<unsigned long long>(o.worst), o.mean);
  }

  void trees(const std::vector<Results>& all) const {
    std::fprintf(out_, "\nTables 4.3, 4.4  hierarchies (leaves of at most 3 boxes of each kind; height in levels)\n");
    std::fprintf(out_, "%-10s %-14s %9s %9s %9s %7s %9s %9s\n", "", "", "objects", "nodes", "leaves", "height",
                 "build s", "B/object");
    for (const Results& r : all) {
      const Model& m = *r.model;
      const auto line = [&](const char* what, const Tree& t, double seconds) {
        std::fprintf(out_, "%-10s %-14s %9zu %9zu %9zu %7u %9.3f %9.1f\n", m.name.c_str(), what, m.boxes.size(),
                     t.nodes.size(), t.leaves, t.height, seconds,
                     double(t.nodes.size()) * 48.0 / double(m.boxes.size()));
      };
      line("median", m.median, m.median_seconds);
      line("mean", m.mean, m.mean_seconds);
      line("median leaf 1", build_tree(m.boxes, {}, Split::kMedian, 1), 0.0);
      line("mean leaf 1", build_tree(m.boxes, {}, Split::kMean, 1), 0.0);
      if (const Run* run = r.find(kProduction))
        std::fprintf(out_, "%-10s %-14s %9zu %9s %9s %7s %9.3f %9.1f\n", m.name.c_str(), kProduction, m.boxes.size(),
                     "", "", "", run->build_seconds, double(run->memory_bytes) / double(m.boxes.size()));
    }
  }

  void best(const std::vector<Results>& all) const {
    std::fprintf(out_,
                 "\nTable 4.8  the best set of optimisations per model, of 32 on the better of mean and median\n");
    for (const Results& r : all) {
      const Run *best = r.find(r.best_flags), *none = r.find(on_tree(r.best_tree));
      std::fprintf(out_, "%-10s %-52s %8.4f ms, x%.2f of none\n", r.model->name.c_str(), r.best_flags.c_str(),
                   best->fastest_ms, none->fastest_ms / best->fastest_ms);
      for (unsigned flags = 0; flags <= kAllFlags; ++flags) row(r, r.find(on_tree(r.best_tree, flags)));
    }
  }

  void fastest(const std::vector<Results>& all) const {
    std::fprintf(out_, "\nProduction against the fastest exact variant (ms a frame, fastest pass)\n");
    std::fprintf(out_, "%-10s %9s %10s %10s %6s  fastest exact variant\n", "", "visible", "production", "variant",
                 "ratio");
    for (const Results& r : all) {
      const Run *production = r.find(kProduction), *best = r.fastest_exact();
      if (production == nullptr || best == nullptr) continue;
      std::fprintf(out_, "%-10s %9.0f %10.5f %10.5f %6.2f  %s\n", r.model->name.c_str(), production->mean_visible,
                   production->fastest_ms, best->fastest_ms, best->fastest_ms / production->fastest_ms,
                   best->variant.c_str());
    }
  }

 private:
  std::FILE* out_;
};

std::vector<Variant> without_tree(const Results&) {
  std::vector<Variant> variants;
  for (const Test test : {Test::kRadarTwoAnswers, Test::kRadar, Test::kVertices, Test::kCorners, Test::kSplit})
    variants.push_back({.test = test});
  for (const unsigned flag : {kPlaneCoherency, kOctant, kMotion, kPreTest}) variants.push_back({.flags = flag});
  return variants;
}

std::vector<Variant> trees_and_walks(const Results&) {
  std::vector<Variant> variants;
  for (const TreeKind tree : {TreeKind::kMedian, TreeKind::kMean})
    for (const Traversal walk : {Traversal::kStack, Traversal::kStackless, Traversal::kCompact})
      variants.push_back(on_tree(tree, 0, walk));
  return variants;
}

std::vector<Variant> with_simd(const Results& r) {
  std::vector<Variant> variants;
  for (const TreeKind tree : {TreeKind::kNone, r.best_tree})
    for (const Test test : {Test::kVertices, Test::kSplit})
      for (const bool simd : {false, true}) variants.push_back({.tree = tree, .test = test, .simd = simd});
  return variants;
}

/// Threads, and items tested on their own.
std::vector<Variant> others(const Results& r) {
  std::vector<Variant> variants;
  for (const Variant& v : r.variants)
    if (v.threads != Threads::kOne || (v.tree != TreeKind::kNone && v.test_items)) variants.push_back(v);
  return variants;
}

}  // namespace

void print_tables(const std::vector<Results>& all, std::FILE* out) {
  const Printer print(out);
  print.operations(*all.back().model);
  print.table(all, "Table 4.2  without hierarchy", without_tree);
  print.trees(all);
  print.table(all, "Tables 4.5, 4.6  mean and median, and walks", trees_and_walks);
  print.best(all);
  print.table(all, "Table 4.9  SIMD", with_simd);
  print.table(all, "Figures 4.13 to 4.16  threads, other tests on trees", others);
  print.fastest(all);
}

void print_runs(const std::vector<Results>& all, std::FILE* out) {
  const Printer print(out);
  for (const Results& r : all) {
    print.header(r.model->name);
    for (const Run& run : r.runs) print.row(r, &run);
  }
}

// --- JSON and plots --------------------------------------------------------------------------------------------------

json::Value to_json(const Results& r) {
  json::Value runs = json::Value::array();
  for (const Run& run : r.runs)
    runs.push_back({{"variant", run.variant},
                    {"promise", run.promise ? name(*run.promise) : "none"},
                    {"mean_ms", run.mean_ms},
                    {"median_ms", run.median_ms},
                    {"fastest_ms", run.fastest_ms},
                    {"min_ms", run.min_ms},
                    {"max_ms", run.max_ms},
                    {"mean_visible", run.mean_visible},
                    {"nodes_tested", run.mean_nodes},
                    {"boxes_tested", run.mean_boxes},
                    {"extra_to_p_vertex", run.per_sample(run.errors.extra)},
                    {"missing_of_p_vertex", run.per_sample(run.errors.missing)},
                    {"false_positives", run.false_positives()},
                    {"false_negatives", run.false_negatives()},
                    {"build_seconds", run.build_seconds},
                    {"memory_bytes", run.memory_bytes}});
  return {{"model", r.model->name},
          {"boxes", r.model->boxes.size()},
          {"frames", r.model->path.views.size()},
          {"best", r.best_flags},
          {"runs", std::move(runs)}};
}

core::Expected<void> write_plot(const Results& r, const std::string& figure, const std::vector<const Run*>& runs,
                                const std::string& directory) {
  using Style = apps::PanelSeries::Style;
  std::vector<apps::PanelSeries> lines;
  for (const Run* run : runs) {
    lines.push_back({run->variant, {}, run->origin == Origin::kProduction ? Style::kHeavyLine : Style::kLine});
    for (std::size_t i = 0; i < run->ms.size(); ++i) lines.back().points.push_back({double(i), run->ms[i], {}});
  }
  std::string file = "figure_" + figure + "_" + r.model->name;
  std::replace(file.begin(), file.end(), '.', '_');
  return apps::write_text(directory + "/" + file + ".svg",
                          apps::svg_panels({.title = "Figure " + figure + ", " + r.model->name,
                                            .x_label = "frame",
                                            .y_label = "ms a frame",
                                            .panels = {{"", std::move(lines)}},
                                            .log_x = false,
                                            .large = true}));
}

/// The figures come in pairs: platforms, then the aircraft. 4.11 shows others' results and 4.12 is a drawing.
core::Expected<void> write_plots(const Results& r, const std::string& directory) {
  const TreeKind best = r.best_tree;
  const auto threads = [&](Threads scheme, int count) {
    return Variant{.tree = best, .test_items = false, .threads = scheme, .thread_count = count};
  };
  const auto walk = [](TreeKind tree, Traversal traversal) { return on_tree(tree, 0, traversal); };
  const Variant none = on_tree(best), coherent = on_tree(best, kPlaneCoherency | kOctant),
                pre_tested = on_tree(best, kPlaneCoherency | kOctant | kPreTest);
  const std::map<int, std::vector<Variant>> variants_of_figure{
      {1, {{.test = Test::kCorners}, {.test = Test::kRadarTwoAnswers}, {}}},
      {3, {walk(TreeKind::kMean, Traversal::kStack), walk(TreeKind::kMedian, Traversal::kStack)}},
      {5, {walk(best, Traversal::kStack), walk(best, Traversal::kStackless), none}},
      {7, {none, coherent}},
      {9, {none, coherent, pre_tested}},
      {13, {none, threads(Threads::kStatic, 1), threads(Threads::kStatic, 2), threads(Threads::kStatic, 4)}},
      {15, {none, threads(Threads::kRing, 2), threads(Threads::kTasks, 2)}}};
  for (const auto& [number, variants] : variants_of_figure) {
    std::vector<const Run*> runs;
    for (const Variant& v : variants)
      if (const Run* run = r.find(v)) runs.push_back(run);
    if (const Run* production = r.find(kProduction)) runs.push_back(production);
    runs.push_back(&r.runs.back());
    // 4.3 and 4.4 part the models by the winning tree instead.
    const bool second = number == 3 ? best != TreeKind::kMean : r.model->name == "aircraft";
    if (auto w = write_plot(r, "4." + std::to_string(number + (second ? 1 : 0)), runs, directory); !w) return w;
  }
  return {};
}

}  // namespace sightline::study
