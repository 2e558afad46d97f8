// The study's figures: CSV, SVG, JSON.
#include <algorithm>
#include <cstdio>
#include <map>
#include <string>

#include "sightline/apps/common/cli.h"
#include "sightline/bench/study_report.h"
#include "sightline/study/line_svg.h"
#include "sightline/study/scatter_svg.h"

namespace sightline::bench {
namespace {

using study::on_tree;
using study::Origin;
using study::Results;
using study::Run;
using study::Test;
using study::Threads;
using study::Traversal;
using study::TreeKind;
using study::Variant;
using study::with_flags;
using Json = nlohmann::ordered_json;

const char* promise_of(const Run& run) {
  return run.promise ? study::name(*run.promise) : "none";
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

std::string figure_svg(const Results& r, const std::string& figure, const std::vector<const Run*>& runs) {
  study::LinePlot plot{
      "Figure " + figure + ", " + r.model->name + ", " + r.path->name, "frame", "ms a frame", true, {}};
  for (const Run* run : runs) {
    study::Line line{run->variant, {}, run->origin == Origin::kProduction};
    for (std::size_t i = 0; i < run->ms.size(); ++i) line.points.emplace_back(double(i), run->ms[i]);
    plot.lines.push_back(std::move(line));
  }
  return study::to_svg(plot);
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
  study::LinePlot time{"Limited depth: time, " + r.model->name, "levels", "ms a frame", true, {}};
  study::LinePlot error{"Limited depth: error, " + r.model->name, "levels", "false positives a frame", true, {}};
  std::string csv = "tree,levels,fastest ms,false positives\n";
  for (const TreeKind tree : {r.best_tree, TreeKind::kSah}) {
    study::Line times{tree == TreeKind::kSah ? "SAH" : tree == TreeKind::kMean ? "mean" : "median", {}, false};
    study::Line errors = times;
    for (std::size_t i = 0; i < r.variants.size(); ++i) {
      const Variant& v = r.variants[i];
      if (v.tree != tree || v.max_depth == 0xff) continue;
      const Run& run = r.runs[i];
      times.points.emplace_back(v.max_depth, run.fastest_ms);
      errors.points.emplace_back(v.max_depth, run.false_positives());
      csv += times.label + ',' + std::to_string(v.max_depth) + ',' + std::to_string(run.fastest_ms) + ',' +
             std::to_string(run.false_positives()) + '\n';
    }
    time.lines.push_back(std::move(times));
    error.lines.push_back(std::move(errors));
  }
  if (auto w = write_both(directory / ("depth_" + r.model->name), csv, study::to_svg(time)); !w) return w;
  return apps::write_text((directory / ("depth_error_" + r.model->name + ".svg")).string(), study::to_svg(error));
}

core::Expected<void> write_pareto(const Results& r, const std::filesystem::path& directory) {
  study::ScatterPlot plot;
  plot.title = "Frustum culling, " + r.model->name + " (" + std::to_string(r.model->boxes.size()) + " boxes)";
  plot.x_label = "time per frame, ms (mean over the path of the fastest pass)";
  plot.y_label = "false positives per frame (boxes that do not meet the frustum)";
  plot.groups = {"no tree",        "mean or median tree", "SAH tree",   "limited depth",
                 "threads",        "loses visible boxes", "production", "brute force",
                 "other libraries"};
  std::string csv =
      "variant,promise,fastest ms,mean ms,median ms,mean visible,false positives,false negatives,nodes,boxes,bytes\n";
  for (const Run& run : r.runs) {
    const double extra = run.false_positives(), lost = run.false_negatives();
    const bool own = run.origin == Origin::kProduction, brute = run.origin == Origin::kBaseline;
    const bool peer = run.origin == Origin::kPeer;
    const auto has = [&run](const char* part) { return run.variant.find(part) != std::string::npos; };
    plot.points.push_back({run.fastest_ms, extra, run.variant,
                           own              ? 6
                           : peer           ? 8
                           : brute          ? 7
                           : lost > 0.0     ? 5
                           : has("depth<=") ? 3
                           : has(" x")      ? 4
                           : has("SAH")     ? 2
                           : has("no tree") ? 0
                                            : 1,
                           run.variant == "production" || brute || peer, lost == 0.0});
    char line[256];
    std::snprintf(line, sizeof(line), ",%s,%.6f,%.6f,%.6f,%.1f,%.2f,%.2f,%.0f,%.0f,%zu\n", promise_of(run),
                  run.fastest_ms, run.mean_ms, run.median_ms, run.mean_visible, extra, lost, run.mean_nodes,
                  run.mean_boxes, run.memory_bytes);
    csv += run.variant + line;
  }
  return write_both(directory / ("pareto_" + r.model->name), csv, study::to_svg(plot));
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

}  // namespace sightline::bench
