// sightline-bench-study: the CPU culling techniques of study/ on made-up platforms and an aircraft, beside production
// and brute force, in one run. Prints the tables that S2 (2009, chapters 3 and 4) has, writes the data of its figures.
#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "sightline/apps/common/cli.h"
#include "sightline/apps/common/model.h"
#include "sightline/core/camera_path.h"
#include "sightline/core/snapshot.h"
#include "sightline/importers/plant_generator.h"
#include "sightline/study/aircraft.h"
#include "sightline/study/camera.h"
#include "sightline/study/measure.h"
#include "sightline/study/operations.h"
#include "sightline/study/scatter_svg.h"
#include "sightline/study/session.h"

namespace {

using namespace sightline;
using study::on_tree;
using study::Results;
using study::Run;
using study::Simd;
using study::Test;
using study::Threads;
using study::Traversal;
using study::TreeKind;
using study::Variant;
using study::with_flags;
using Json = nlohmann::ordered_json;

struct Options {
  bool tables = false;
  std::string csv, json;
  int frames = 120, passes = 3, samples = 10;
  double scale = 1.0;
  std::vector<std::string> only;
  apps::ModelOptions files;
};

// --- models ----------------------------------------------------------------------------------------------------------

/// Tables 3.1 and 3.2. `objects` is the sum that the study uses; `printed` what table 3.2 says.
struct Platform {
  const char* name;
  std::uint64_t cylinders, cones, tori, meshes, printed;
  double seconds;
  std::uint64_t objects() const { return cylinders + cones + tori + meshes; }
};
constexpr Platform kPlatforms[] = {{"P-38", 81374, 3917, 0, 53578, 138869, 80},
                                   {"P-40", 221933, 3814, 39586, 82, 265415, 87},
                                   {"P-43", 280123, 13212, 0, 699521, 280123, 72},
                                   {"P-50", 336591, 14192, 341168, 21484, 713435, 92}};
constexpr double kAircraftSeconds = 73;

/// A tour with a far plane behind the scene, so that every test can be used.
void add_views(const core::CameraPath& path, const core::AabbD& bounds, int frames, study::Model& model) {
  const double far = 3.0 * glm::length(bounds.size()) + 10.0;
  for (int i = 0; i < frames; ++i) {
    const double t = path.begin() + (path.end() - path.begin()) * i / std::max(1, frames - 1);
    const core::CameraSample s = path.sample(t);
    if (auto view = core::View::perspective(s.pose, s.fovy, 4.0 / 3.0, 0.1, far)) model.views.push_back(*view);
  }
}

study::Model from_boxes(std::string name, std::vector<core::Aabb> boxes, std::vector<std::uint8_t> kinds, int frames,
                        double seconds) {
  study::Model model;
  model.name = std::move(name);
  model.boxes = std::move(boxes);
  model.kinds = std::move(kinds);
  model.seconds = seconds;
  core::AabbD bounds;
  std::vector<core::dvec3> centres;
  for (const core::Aabb& b : model.boxes) {
    bounds.grow(core::AabbD{core::dvec3(b.min), core::dvec3(b.max)});
    centres.push_back(0.5 * (core::dvec3(b.min) + core::dvec3(b.max)));
  }
  add_views(core::make_tour(bounds, centres, seconds), bounds, frames, model);
  return model;
}

/// Boxes in the order of insertion, relative to the snapshot's origin.
study::Model from_scene(const std::string& name, const core::Scene& scene, int frames, double seconds) {
  const core::Snapshot snapshot(scene);
  struct Item {
    core::ItemId id;
    core::Slot slot;
  };
  std::vector<Item> items;
  for (core::Slot s = 0; s < snapshot.size(); ++s)
    if (!snapshot.bounds().box(s).empty()) items.push_back({snapshot.item(s), s});
  std::sort(items.begin(), items.end(), [](const Item& a, const Item& b) { return a.id < b.id; });
  std::vector<core::Aabb> boxes;
  std::vector<std::uint8_t> kinds;
  for (const Item& item : items) {
    boxes.push_back(snapshot.bounds().box(item.slot));
    const core::Kind kind = snapshot.kind(item.slot);
    kinds.push_back(kind == core::Kind::kCylinder        ? 0
                    : kind == core::Kind::kSnout         ? 1
                    : kind == core::Kind::kCircularTorus ? 2
                                                         : 3);
  }
  return from_boxes(name, std::move(boxes), std::move(kinds), frames, seconds);
}

core::Expected<study::Model> make_platform(const Platform& platform, const Options& options) {
  core::Scene scene;
  importers::PlantConfig config;
  config.items = std::max<std::uint64_t>(1000, std::uint64_t(double(platform.objects()) * options.scale));
  config.seed = platform.objects();
  if (auto made = importers::generate_plant(config, scene); !made) return tl::unexpected(made.error());
  if (auto done = scene.commit(); !done) return tl::unexpected(done.error());
  return from_scene(platform.name, scene, options.frames, platform.seconds);
}

// --- tables ----------------------------------------------------------------------------------------------------------

double fps(double ms) {
  return ms > 0.0 ? 1e3 / ms : 0.0;
}

void table_header(const char* title) {
  std::printf("\n%s\n", title);
  std::printf("%-44s %9s %9s %9s %9s %9s %9s %9s %9s %9s\n", "", "processed", "min fps", "max fps", "mean fps",
              "median ms", "fast. ms", "visible", "false +", "false -");
}

/// Rows as in S2 (frames processed in the path's seconds, fps), with visible counts and errors per sampled frame.
void row(const Results& r, const Run* run) {
  if (run == nullptr) return;
  const double n = double(std::max<std::size_t>(1, run->samples));
  std::printf("%-44s %9.0f %9.1f %9.1f %9.1f %9.4f %9.4f %9.0f %9.1f %9.1f\n", run->variant.c_str(),
              r.model->seconds * fps(run->mean_ms), fps(run->max_ms), fps(run->min_ms), fps(run->mean_ms),
              run->median_ms, run->fastest_ms, run->mean_visible, double(run->errors.false_positives) / n,
              double(run->errors.false_negatives) / n);
}
void common_rows(const Results& r) {
  row(r, r.find({.tree = TreeKind::kWide}));
  row(r, &r.brute_force());
}

void print_operations(const study::Model& model) {
  const study::OperationTable table = study::count_operations(model.boxes, model.views);
  std::printf("\nTable 4.1  float operations and comparisons, counted by running the tests (%s)\n", model.name.c_str());
  std::printf("%-28s %9s %9s %9s %9s\n", "", "update", "best", "worst", "mean");
  for (const auto& o : table)
    std::printf("%-28s %9llu %9llu %9llu %9.1f\n", o.name.c_str(), static_cast<unsigned long long>(o.update),
                static_cast<unsigned long long>(o.best), static_cast<unsigned long long>(o.worst), o.mean);
}

void print_trees(const std::vector<Results>& all) {
  std::printf("\nTables 4.3, 4.4  hierarchies (leaves of at most 3 boxes of each kind; height in levels)\n");
  std::printf("%-10s %-14s %9s %9s %9s %7s %9s %9s\n", "", "", "objects", "nodes", "leaves", "height", "build s",
              "B/object");
  for (const Results& r : all) {
    const study::Model& m = *r.model;
    const auto line = [&](const char* what, const study::Tree& t, double seconds) {
      std::printf("%-10s %-14s %9zu %9zu %9zu %7u %9.3f %9.1f\n", m.name.c_str(), what, m.boxes.size(), t.nodes.size(),
                  t.leaves, t.height, seconds, double(t.nodes.size()) * 48.0 / double(m.boxes.size()));
    };
    line("median", m.median, m.median_seconds);
    line("mean", m.mean, m.mean_seconds);
    line("SAH", m.sah, m.sah_seconds);
    line("median leaf 1", study::build_tree(m.boxes, {}, study::Split::kMedian, 1), 0.0);
    line("mean leaf 1", study::build_tree(m.boxes, {}, study::Split::kMean, 1), 0.0);
    std::printf("%-10s %-14s %9zu %9s %9s %7s %9.3f %9.1f\n", m.name.c_str(), "production", m.boxes.size(), "", "", "",
                r.production_seconds, double(r.find({.tree = TreeKind::kWide})->memory_bytes) / double(m.boxes.size()));
  }
}

void print_best(const std::vector<Results>& all) {
  std::printf("\nTable 4.8  the best set of optimisations per model, of 32 on the better of mean and median\n");
  for (const Results& r : all) {
    const Run *best = r.find(r.best_flags), *none = r.find(on_tree(r.best_tree));
    std::printf("%-10s %-52s %8.4f ms, x%.2f of none\n", r.model->name.c_str(), r.best_flags.c_str(), best->fastest_ms,
                none->fastest_ms / best->fastest_ms);
    for (unsigned f = 0; f < 32; ++f) row(r, r.find(with_flags(on_tree(r.best_tree), f)));
  }
}

void print_tables(const std::vector<Results>& all) {
  print_operations(*all.back().model);
  for (const Results& r : all) {
    table_header(("Table 4.2  without hierarchy: " + r.model->name).c_str());
    for (const Test t : {Test::kRadarTwoAnswers, Test::kRadar, Test::kRadarByLimit, Test::kVertices, Test::kCorners,
                         Test::kSplit, Test::kSphere})
      row(r, r.find({.test = t}));
    for (const unsigned f : {1u, 2u, 8u, 16u}) row(r, r.find(with_flags({}, f)));
    common_rows(r);
  }
  print_trees(all);
  for (const Results& r : all) {
    table_header(("Tables 4.5, 4.6  mean and median, and walks: " + r.model->name).c_str());
    for (const TreeKind tree : {TreeKind::kMedian, TreeKind::kMean, TreeKind::kSah})
      for (const Traversal t : {Traversal::kStack, Traversal::kStackless, Traversal::kCompact})
        row(r, r.find(on_tree(tree, t)));
    common_rows(r);
  }
  print_best(all);
  for (const Results& r : all) {
    table_header(("Table 4.9  SIMD: " + r.model->name).c_str());
    for (const Variant& v :
         {Variant{}, Variant{.simd = Simd::kPerTest}, Variant{.simd = Simd::kOverBoxes}, Variant{.test = Test::kSplit},
          Variant{.test = Test::kSplit, .simd = Simd::kPerTest}, Variant{.tree = r.best_tree},
          Variant{.tree = r.best_tree, .simd = Simd::kPerTest}, Variant{.tree = r.best_tree, .test = Test::kSplit},
          Variant{.tree = r.best_tree, .test = Test::kSplit, .simd = Simd::kPerTest}})
      row(r, r.find(v));
    common_rows(r);
  }
  for (const Results& r : all) {
    table_header(("Figures 4.13 to 4.16  threads, limited depth, other tests on trees: " + r.model->name).c_str());
    for (const Run& run : r.runs)
      if (run.variant.find(" x") != std::string::npos || run.variant.find("depth<=") != std::string::npos ||
          run.variant.find("whole-leaves") == std::string::npos)
        row(r, &run);
  }
}

// --- files -----------------------------------------------------------------------------------------------------------

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

/// Figures 4.1 … 4.16 come in pairs: platforms, then the aircraft. 4.11 and 4.12 hold no measurement of S2's own.
core::Expected<void> write_figures(const Results& r, bool aircraft, const std::filesystem::path& directory) {
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
    runs.push_back(r.find({.tree = TreeKind::kWide}));
    runs.push_back(&r.brute_force());
    // 4.3 and 4.4 part the models by the winning tree instead.
    const int shown = number == 3 ? (best == TreeKind::kMean ? 3 : 4) : number + (aircraft ? 1 : 0);
    const auto file = directory / ("figure_4_" + std::to_string(shown) + "_" + r.model->name + ".csv");
    if (auto written = apps::write_text(file.string(), figure_csv(runs)); !written) return written;
  }
  return {};
}

core::Expected<void> write_pareto(const Results& r, const std::filesystem::path& directory) {
  study::ScatterPlot plot;
  plot.title = "Frustum culling, " + r.model->name + " (" + std::to_string(r.model->boxes.size()) + " boxes)";
  plot.x_label = "time per frame, ms (mean over the path of the fastest pass)";
  plot.y_label = "false positives per frame (boxes that do not meet the frustum)";
  plot.groups = {"no tree", "mean or median tree", "SAH tree",   "limited depth",
                 "threads", "loses visible boxes", "production", "brute force"};
  std::string csv =
      "variant,promise,fastest ms,mean ms,median ms,mean visible,false positives,false negatives,nodes,boxes,bytes\n";
  for (const Run& run : r.runs) {
    const double n = double(std::max<std::size_t>(1, run.samples));
    const double extra = double(run.errors.false_positives) / n, lost = double(run.errors.false_negatives) / n;
    const bool own = run.variant == "production", brute = &run == &r.brute_force();
    const auto has = [&run](const char* part) { return run.variant.find(part) != std::string::npos; };
    plot.points.push_back({run.fastest_ms, extra, run.variant,
                           own              ? 6
                           : brute          ? 7
                           : lost > 0.0     ? 5
                           : has("depth<=") ? 3
                           : has(" x")      ? 4
                           : has("SAH")     ? 2
                           : has("no tree") ? 0
                                            : 1,
                           own || brute, lost == 0.0});
    char line[256];
    std::snprintf(line, sizeof(line), ",%s,%.6f,%.6f,%.6f,%.1f,%.2f,%.2f,%.0f,%.0f,%zu\n",
                  run.has_promise ? study::name(run.promise) : "none", run.fastest_ms, run.mean_ms, run.median_ms,
                  run.mean_visible, extra, lost, run.mean_nodes, run.mean_boxes, run.memory_bytes);
    csv += run.variant + line;
  }
  if (auto w = apps::write_text((directory / ("pareto_" + r.model->name + ".csv")).string(), csv); !w) return w;
  return apps::write_text((directory / ("pareto_" + r.model->name + ".svg")).string(), study::to_svg(plot));
}

Json to_json(const Results& r) {
  Json runs = Json::array();
  for (const Run& run : r.runs) {
    const double n = double(std::max<std::size_t>(1, run.samples));
    runs.push_back({{"variant", run.variant},
                    {"promise", run.has_promise ? study::name(run.promise) : "none"},
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
                    {"false_positives", double(run.errors.false_positives) / n},
                    {"false_negatives", double(run.errors.false_negatives) / n},
                    {"memory_bytes", run.memory_bytes}});
  }
  return {{"model", r.model->name},
          {"boxes", r.model->boxes.size()},
          {"frames", r.model->views.size()},
          {"best", r.best_flags},
          {"runs", std::move(runs)}};
}

// --- the tool --------------------------------------------------------------------------------------------------------

core::Expected<std::vector<study::Model>> make_models(const Options& options) {
  std::vector<study::Model> models;
  const auto wanted = [&](const std::string& name) {
    return options.only.empty() || std::find(options.only.begin(), options.only.end(), name) != options.only.end();
  };
  for (const Platform& p : kPlatforms) {
    if (!wanted(p.name)) continue;
    if (p.objects() != p.printed)
      std::fprintf(stderr, "%s: tables 3.1 and 3.2 add up to %llu objects, table 3.2 prints %llu\n", p.name,
                   static_cast<unsigned long long>(p.objects()), static_cast<unsigned long long>(p.printed));
    auto model = make_platform(p, options);
    if (!model) return tl::unexpected(model.error());
    models.push_back(std::move(*model));
  }
  if (!options.files.files.empty()) {
    auto loaded = apps::load_model(options.files);
    if (!loaded) return tl::unexpected(loaded.error());
    models.push_back(from_scene(std::filesystem::path(options.files.files[0]).stem().string(), *loaded->scene,
                                options.frames, 60.0));
  }
  if (wanted("aircraft"))
    models.push_back(from_boxes(
        "aircraft",
        study::make_aircraft(std::max<std::size_t>(1000, std::size_t(options.scale * study::kAircraftMeshes))), {},
        options.frames, kAircraftSeconds));
  if (models.empty()) return core::fail("--only: no such model; there are P-38, P-40, P-43, P-50 and aircraft");
  return models;
}

core::Expected<int> run_study(const Options& options) {
  auto models = make_models(options);
  if (!models) return tl::unexpected(models.error());
  std::vector<Results> all;
  Json json = Json::array();
  for (study::Model& model : *models) {
    if (model.boxes.empty()) return core::fail(model.name + ": nothing to cull");
    model.prepare(std::size_t(options.samples));
    const auto progress = [&model](const std::string& variant) {
      std::fprintf(stderr, "\r\033[K%s: %s", model.name.c_str(), variant.c_str());
    };
    all.push_back(study::run_everything(model, options.passes, progress));
    json.push_back(to_json(all.back()));
    std::fprintf(stderr, "\r\033[K");
  }
  if (options.tables && options.json != "-") print_tables(all);
  if (!options.csv.empty()) {
    std::error_code error;
    std::filesystem::create_directories(options.csv, error);
    for (const Results& r : all) {
      if (auto w = write_figures(r, r.model->name == "aircraft", options.csv); !w) return tl::unexpected(w.error());
      if (auto w = write_pareto(r, options.csv); !w) return tl::unexpected(w.error());
    }
  }
  if (!options.json.empty())
    if (auto w = apps::write_text(options.json, apps::to_text(json)); !w) return tl::unexpected(w.error());
  return apps::kExitOk;
}

int run_tool(int argc, char** argv) {
  CLI::App app{"CPU frustum culling techniques of 2009 and before, beside production: error against time.",
               "sightline-bench-study"};
  Options options;
  app.add_flag("--tables", options.tables, "print the tables (not with --json -)");
  app.add_option("--csv", options.csv, "write figures' data, Pareto data and plots into this directory");
  app.add_option("--json", options.json, "write all figures to this file, or - for standard output");
  app.add_option("--frames", options.frames, "frames per path")->check(CLI::Range(2, 100000));
  app.add_option("--passes", options.passes, "times each path is flown; medians count")->check(CLI::Range(1, 1000));
  app.add_option("--samples", options.samples, "frames that errors are counted on")->check(CLI::Range(1, 100000));
  app.add_option("--scale", options.scale, "share of the objects of each model")
      ->check(apps::accepted_by(apps::parse_finite))
      ->check(CLI::Range(1e-3, 10.0));
  app.add_option("--only", options.only, "these models alone: P-38, P-40, P-43, P-50, aircraft");
  app.add_option("--model", options.files.files, "a real model besides (RVM, OBJ)");
  apps::describe(app, "  sightline-bench-study --tables --scale 0.05 --frames 30\n");
  return apps::run(app, argc, argv, [&] { return run_study(options); });
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run_tool(argc, argv);
  } catch (const std::exception& error) {  // out of memory
    std::fputs("sightline-bench-study: ", stderr);
    std::fputs(error.what(), stderr);
    std::fputc('\n', stderr);
  }
  return apps::kExitFailure;
}
