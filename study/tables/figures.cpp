// The study's figures: CSV, SVG, JSON.
#include <algorithm>
#include <array>
#include <cstdio>
#include <map>
#include <string>

#include "sightline/apps/common/output.h"
#include "sightline/apps/common/svg_plot.h"
#include "sightline/study/pareto.h"
#include "sightline/study/tables/report.h"

namespace sightline::study {
namespace {

using apps::PanelSeries;
using Json = json::Value;
using Style = PanelSeries::Style;

const char* promise_of(const Run& run) {
  return run.promise ? name(*run.promise) : "none";
}

std::string figure_csv(const std::vector<const Run*>& runs) {
  std::string text = "frame,visible";
  for (const Run* r : runs) text += ",ms " + r->variant;
  text += '\n';
  for (std::size_t i = 0; i < runs[0]->ms.size(); ++i) {
    text += std::to_string(i) + ',' + std::to_string(runs[0]->visible[i]);
    for (const Run* r : runs) {
      char number[32];
      std::snprintf(number, sizeof(number), ",%.6f", r->ms[i]);
      text += number;
    }
    text += '\n';
  }
  return text;
}

/// Lines over frames or levels.
std::string lines_svg(const std::string& title, const std::string& x_label, const std::string& y_label,
                      std::vector<PanelSeries> lines) {
  return apps::svg_panels({.title = title,
                           .x_label = x_label,
                           .y_label = y_label,
                           .panels = {{"", std::move(lines)}},
                           .log_x = false,
                           .large = true});
}

std::string figure_svg(const Results& r, const std::string& figure, const std::vector<const Run*>& runs) {
  std::vector<PanelSeries> lines;
  for (const Run* run : runs) {
    lines.push_back({run->variant, {}, run->origin == Origin::kProduction ? Style::kHeavyLine : Style::kLine});
    for (std::size_t i = 0; i < run->ms.size(); ++i) lines.back().points.push_back({double(i), run->ms[i], {}});
  }
  return lines_svg("Figure " + figure + ", " + r.model->name + ", " + r.path->name, "frame", "ms a frame",
                   std::move(lines));
}

core::Expected<void> write_both(const std::filesystem::path& stem, const std::string& csv, const std::string& svg) {
  if (auto written = apps::write_text(stem.string() + ".csv", csv); !written) return written;
  return apps::write_text(stem.string() + ".svg", svg);
}

/// Figures 4.1 … 4.16 come in pairs: platforms, then the aircraft. 4.11 shows others' results and 4.12 is a drawing.
core::Expected<void> write_paths(const Results& r, bool aircraft, const std::filesystem::path& directory) {
  const TreeKind best = r.best_tree;
  const auto threads = [&](Threads scheme, int count) {
    return Variant{.tree = best, .test_items = false, .threads = scheme, .thread_count = count};
  };
  const Variant none = on_tree(best);
  const std::map<int, std::vector<Variant>> figures{
      {1, {{.test = Test::kCorners}, {.test = Test::kRadarTwoAnswers}, {}}},
      {3, {on_tree(TreeKind::kMean, Traversal::kStack), on_tree(TreeKind::kMedian, Traversal::kStack)}},
      {5, {on_tree(best, Traversal::kStack), on_tree(best, Traversal::kStackless), none}},
      {7, {none, with_flags(none, 3)}},
      {9, {none, with_flags(none, 3), with_flags(none, 19)}},
      {13, {none, threads(Threads::kStatic, 1), threads(Threads::kStatic, 2), threads(Threads::kStatic, 4)}},
      {15, {none, threads(Threads::kRing, 2), threads(Threads::kTasks, 2)}}};
  for (const auto& [number, variants] : figures) {
    std::vector<const Run*> runs;
    for (const Variant& v : variants)
      if (const Run* run = r.find(v)) runs.push_back(run);
    if (const Run* production = r.production()) runs.push_back(production);
    runs.push_back(&r.brute_force());
    // 4.3 and 4.4 part the models by the winning tree instead.
    const int shown = number == 3 ? (best == TreeKind::kMean ? 3 : 4) : number + (aircraft ? 1 : 0);
    if (auto w = write_figure(r, "4." + std::to_string(shown), runs, directory); !w) return w;
  }
  return {};
}

/// Levels walked against time and against error, of the trees that limited depth was run on.
core::Expected<void> write_depths(const Results& r, const std::filesystem::path& directory) {
  std::vector<PanelSeries> time, error;
  std::string csv = "tree,levels,fastest ms,false positives\n";
  for (const TreeKind tree : {r.best_tree, TreeKind::kSah}) {
    PanelSeries times{tree == TreeKind::kSah ? "SAH" : tree == TreeKind::kMean ? "mean" : "median", {}, Style::kLine};
    PanelSeries errors = times;
    for (std::size_t i = 0; i < r.variants.size(); ++i) {
      const Variant& v = r.variants[i];
      if (v.tree != tree || v.max_depth == 0xff) continue;
      const Run& run = r.runs[i];
      times.points.push_back({double(v.max_depth), run.fastest_ms, {}});
      errors.points.push_back({double(v.max_depth), run.false_positives(), {}});
      csv += times.label + ',' + std::to_string(v.max_depth) + ',' + std::to_string(run.fastest_ms) + ',' +
             std::to_string(run.false_positives()) + '\n';
    }
    time.push_back(std::move(times));
    error.push_back(std::move(errors));
  }
  const std::string time_svg =
      lines_svg("Limited depth: time, " + r.model->name, "levels", "ms a frame", std::move(time));
  if (auto w = write_both(directory / ("depth_" + r.model->name), csv, time_svg); !w) return w;
  return apps::write_text(
      (directory / ("depth_error_" + r.model->name + ".svg")).string(),
      lines_svg("Limited depth: error, " + r.model->name, "levels", "false positives a frame", std::move(error)));
}

/// Groups of the plot of error against time.
enum Group : std::size_t { kNoTree, kTree, kSahTree, kLimitedDepth, kThreads, kLossy, kProduction, kBrute, kPeers };
constexpr std::array kGroups{"no tree",        "mean or median tree", "SAH tree",   "limited depth",
                             "threads",        "loses visible boxes", "production", "brute force",
                             "other libraries"};

Group group_of(const Run& run) {
  const auto has = [&run](const char* part) { return run.variant.find(part) != std::string::npos; };
  return run.origin == Origin::kProduction ? kProduction
         : run.origin == Origin::kPeer     ? kPeers
         : run.origin == Origin::kBaseline ? kBrute
         : run.false_negatives() > 0.0     ? kLossy
         : has("depth<=")                  ? kLimitedDepth
         : has(" x")                       ? kThreads
         : has("SAH")                      ? kSahTree
         : has("no tree")                  ? kNoTree
                                           : kTree;
}

core::Expected<void> write_pareto(const Results& r, const std::filesystem::path& directory) {
  apps::PanelPlot plot;
  plot.title = "Frustum culling, " + r.model->name + " (" + std::to_string(r.model->boxes.size()) + " boxes)";
  plot.x_label = "time per frame, ms (mean over the path of the fastest pass)";
  plot.y_label = "false positives per frame (boxes that do not meet the frustum)";
  plot.large = true;
  std::vector<PanelSeries> groups;
  groups.reserve(kGroups.size() + 1);
  for (const char* group : kGroups) groups.push_back({group, {}, Style::kPoints});
  std::vector<std::array<double, 2>> contenders;
  std::string csv =
      "variant,promise,fastest ms,mean ms,median ms,mean visible,false positives,false negatives,nodes,boxes,bytes\n";
  for (const Run& run : r.runs) {
    const double extra = run.false_positives(), lost = run.false_negatives();
    const bool named = run.variant == "production" || run.origin == Origin::kBaseline || run.origin == Origin::kPeer;
    groups[group_of(run)].points.push_back({run.fastest_ms, extra, named ? run.variant : "", run.variant});
    if (lost == 0.0) contenders.push_back({run.fastest_ms, extra});
    char line[256];
    std::snprintf(line, sizeof(line), ",%s,%.6f,%.6f,%.6f,%.1f,%.2f,%.2f,%.0f,%.0f,%zu\n", promise_of(run),
                  run.fastest_ms, run.mean_ms, run.median_ms, run.mean_visible, extra, lost, run.mean_nodes,
                  run.mean_boxes, run.memory_bytes);
    csv += run.variant + line;
  }
  PanelSeries front{"", {}, Style::kDashes};
  for (const std::size_t i : pareto_front(contenders)) front.points.push_back({contenders[i][0], contenders[i][1], {}});
  groups.insert(groups.begin(), std::move(front));
  plot.panels = {{"", std::move(groups)}};
  return write_both(directory / ("pareto_" + r.model->name), csv, apps::svg_panels(plot));
}

}  // namespace

Json to_json(const Results& r) {
  Json runs = Json::array();
  for (const Run& run : r.runs) {
    const double n = double(std::max<std::size_t>(1, run.samples));
    runs.push_back({{"variant", run.variant},
                    {"promise", promise_of(run)},
                    {"mean_ms", run.mean_ms},
                    {"median_ms", run.median_ms},
                    {"fastest_ms", run.fastest_ms},
                    {"min_ms", run.min_ms},
                    {"max_ms", run.max_ms},
                    {"mean_visible", run.mean_visible},
                    {"nodes_tested", run.mean_nodes},
                    {"boxes_tested", run.mean_boxes},
                    {"extra_to_p_vertex", double(run.errors.extra) / n},
                    {"missing_of_p_vertex", double(run.errors.missing) / n},
                    {"false_positives", run.false_positives()},
                    {"false_negatives", run.false_negatives()},
                    {"build_seconds", run.build_seconds},
                    {"memory_bytes", run.memory_bytes}});
  }
  return {{"model", r.model->name},         {"path", r.path->name}, {"boxes", r.model->boxes.size()},
          {"frames", r.path->views.size()}, {"best", r.best_flags}, {"runs", std::move(runs)}};
}

core::Expected<void> write_figure(const Results& r, const std::string& figure, const std::vector<const Run*>& runs,
                                  const std::filesystem::path& directory) {
  std::string file = "figure_" + figure + "_" + r.model->name;
  std::replace(file.begin(), file.end(), '.', '_');
  return write_both(directory / file, figure_csv(runs), figure_svg(r, figure, runs));
}

core::Expected<void> write_figures(const ModelResults& results, const std::filesystem::path& directory) {
  const Results& r = results.front();
  if (auto w = write_paths(r, r.model->name == "aircraft", directory); !w) return w;
  if (auto w = write_depths(r, directory); !w) return w;
  return write_pareto(r, directory);
}

}  // namespace sightline::study
