// sightline-bench error-time: the cost and the errors of the forms of a primitive.
//
// Without a model: measures each kind separately, with random items 1/16 and 6/10 as large as the image's height.
// Depth, normal and silhouette errors are against the C++ intersections in double. With models: compares whole images
// with those of triangles so small that no pixel shows them. Everything compared is timed in turns.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "sightline/apps/bench/error_time/report.h"
#include "sightline/apps/bench/renderer.h"
#include "sightline/apps/bench/subcommands.h"
#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/model.h"
#include "sightline/apps/common/output.h"
#include "sightline/apps/common/progress.h"
#include "sightline/core/snapshot.h"
#include "sightline/engine/tour.h"
#include "sightline/importers/view_json.h"

namespace sightline::bench::error_time_bench {
namespace {

using Json = json::Value;
namespace fs = std::filesystem;

constexpr int kSegments[] = {6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 256};

struct Options {
  apps::ModelOptions model;
  std::vector<std::string> only;
  std::vector<int> segments;  // none: kSegments
  std::string size, views, csv, plot, json;
  int samples = 3, passes = 7, images = 4, reference = 512;
  std::uint32_t seed = 1;
  gl::ContextPlatform platform = {};
};

void add_options(apps::CommandLine& line, Options& o) {
  apps::add_model_options(line, o.model);
  line.option("MODEL").required(false).described_as("Measure these, each on its own, instead of single kinds");
  std::vector<std::string> kinds;
  for (const core::Kind kind : measured_kinds()) kinds.emplace_back(core::name_of(kind));
  line.add("--only", o.only, "These kinds alone: cylinder, snout, circular_torus, …").one_of(kinds).separated_by(',');
  line.add("--segments", o.segments, "Of the triangles, per full circle; without it 6 8 12 16 24 32 48 64 96 128 256")
      .in_range(3, 4096)
      .separated_by(',');
  line.add("--size", o.size, "Pixels of a frame; 640x480, of models 1280x720").accepted_by(apps::parse_size);
  line.add("--samples", o.samples, "Per pixel and axis where the errors of kinds are taken")
      .in_range(1, 8)
      .shows_default();
  line.add("--images", o.images, "Of two large items each").in_range(1, 64).shows_default();
  line.add("--passes", o.passes, "Of which the median time counts").in_range(1, 1000).shows_default();
  line.add("--seed", o.seed, "Of the random items").shows_default();
  line.add("--views", o.views, "Folder with view files NAME_*.json of models NAME.*; without, views are made up")
      .existing_directory();
  line.add("--reference", o.reference, "Segments of the reference of models").in_range(16, 4096).shows_default();
  line.add("--csv", o.csv, "Write all figures as CSV to FILE, or - for stdout");
  line.add("--plot", o.plot, "Write plots to PREFIX-….svg");
  apps::add_context_option(line, o.platform);
  apps::add_json_option(line, o.json);
  line.examples(
      "  sightline-bench error-time --plot kinds --json kinds.json\n"
      "  sightline-bench error-time --only circular_torus,sphere --segments 12,24,48 --passes 15\n"
      "  sightline-bench error-time plant.rvm --csv plant.csv --plot plant\n"
      "  sightline-bench error-time PIPES.RVM STEEL.RVM --views views/ --reference 256");
}

std::vector<int> segments_of(const Options& o) {
  return o.segments.empty() ? std::vector<int>(std::begin(kSegments), std::end(kSegments)) : o.segments;
}

template <class Results>
core::Expected<void> write_results(const Options& o, const Results& results, Json json, const char* key) {
  for (const auto& result : results) json[key].push_back(to_json(result));
  core::Expected<void> done;
  if (!o.csv.empty()) done = apps::write_text(o.csv, to_csv(results));
  if (done && !o.plot.empty()) done = write_plots(results, o.plot);
  if (done) done = apps::write_json(o.json, json);
  return done;
}

Report shown_on(apps::Progress& progress, std::size_t step, std::size_t steps) {
  return [&progress, step, steps](double share) {
    progress.advance(std::size_t(1000.0 * (double(step) + share) / double(steps)));
  };
}

core::Expected<int> measure_kinds(const Options& o, gl::Context& context, std::FILE* out) {
  const std::array<int, 2> size = *apps::parse_size(o.size.empty() ? "640x480" : o.size);
  const double height = size[1];
  if (3 * size[0] < 4 * size[1] || size[1] < 64) return core::fail("--size: must be 4:3 or wider, and 64 high");
  const KindConfig config{size[0], size[1], o.samples, o.passes, o.seed, segments_of(o)};
  std::vector<core::Kind> kinds;
  for (const core::Kind kind : measured_kinds())
    if (o.only.empty() || std::find(o.only.begin(), o.only.end(), core::name_of(kind)) != o.only.end())
      kinds.push_back(kind);
  std::fprintf(out, "%s, %dx%d, %d x %d samples per pixel, median of %d passes, seed %u\n",
               renderer_line(context).c_str(), size[0], size[1], o.samples, o.samples, o.passes, o.seed);

  const FieldSize sizes[] = {{height / 16.0, 8, 8, 1}, {0.6 * height, 2, 1, o.images}};
  const std::size_t steps = kinds.size() * std::size(sizes);
  std::vector<KindResult> results;
  apps::Progress progress("error against time", 1000);
  for (const core::Kind kind : kinds)
    for (const FieldSize& field : sizes) {
      auto result = measure_kind(context, kind, field, config, shown_on(progress, results.size(), steps));
      if (!result) return tl::unexpected(result.error());
      results.push_back(std::move(*result));
    }
  progress.advance(1000);
  for (const KindResult& result : results) print(result, out);
  print_summary(results, out);
  Json head = renderer_json(context);
  head.update({{"size", size},
               {"samples_per_pixel", o.samples},
               {"passes", o.passes},
               {"seed", o.seed},
               {"kinds", Json::array()}});
  if (auto done = write_results(o, results, head, "kinds"); !done) return tl::unexpected(done.error());
  return apps::kExitOk;
}

/// The views of --views; without it the whole model, and two places of the tour through it.
core::Expected<std::vector<NamedView>> views_of(const Options& o, const std::string& name, const apps::Model& model,
                                                double aspect) {
  std::vector<NamedView> views;
  if (!o.views.empty()) {
    std::map<std::string, fs::path> files;  // sorted by name
    for (const fs::directory_entry& entry : fs::directory_iterator(o.views)) {
      const std::string stem = entry.path().stem().string();
      if (entry.path().extension() == ".json" && stem.rfind(name + "_", 0) == 0)
        files.emplace(stem.substr(name.size() + 1), entry.path());
    }
    for (const auto& [view_name, file] : files) {
      auto view = importers::read_view(file, aspect);
      if (view) view = importers::translated(*view, model.offset);
      if (!view) return tl::unexpected(view.error());
      views.push_back({view_name, *view});
    }
    if (views.empty()) return core::fail(o.views + ": has no view " + name + "_*.json");
    return views;
  }
  const core::Snapshot snapshot(*model.scene);
  const core::FittedBounds fitted = snapshot.bounds().fitted_bounds();
  auto whole = core::View::fit(fitted.bounds, core::kOverviewDirection, apps::kFovy, aspect);
  if (!whole) return tl::unexpected(whole.error());
  views.push_back({"whole", *whole});
  const core::CameraPath tour = engine::make_tour(snapshot.bounds(), fitted);
  for (const int percent : {40, 70}) {
    auto view = tour.view(tour.time_of(percent, 101), aspect);
    if (!view) return tl::unexpected(view.error());
    views.push_back({"tour at " + std::to_string(percent) + " %", *view});
  }
  return views;
}

core::Expected<int> measure_models(const Options& o, gl::Context& context, std::FILE* out) {
  const std::array<int, 2> size = *apps::parse_size(o.size.empty() ? "1280x720" : o.size);
  const ModelConfig config{size[0], size[1], o.passes, o.reference, segments_of(o)};
  std::fprintf(out, "%s, %dx%d, median of %d passes, reference %d segments\n", renderer_line(context).c_str(), size[0],
               size[1], o.passes, o.reference);
  std::vector<NamedModel> results;
  apps::Progress progress("error against time", 1000);
  for (const std::string& file : o.model.files) {
    apps::ModelOptions one = o.model;
    one.files = {file};
    auto model = apps::load_model(one);
    if (!model) return tl::unexpected(model.error());
    if (auto done = model->scene->commit(); !done) return tl::unexpected(done.error());
    const std::string name = fs::path(file).stem().string();
    auto views = views_of(o, name, *model, double(size[0]) / size[1]);
    if (!views) return tl::unexpected(views.error());
    auto figures =
        measure_model(context, *model->scene, *views, config, shown_on(progress, results.size(), o.model.files.size()));
    if (!figures) return tl::unexpected(figures.error());
    results.push_back({name, model->scene->item_count(), std::move(*figures)});
  }
  progress.advance(1000);
  for (const NamedModel& model : results) print(model, out);
  print_summary(results, out);
  Json head = renderer_json(context);
  head.update({{"size", size}, {"passes", o.passes}, {"reference_segments", o.reference}, {"models", Json::array()}});
  if (auto done = write_results(o, results, head, "models"); !done) return tl::unexpected(done.error());
  return apps::kExitOk;
}

core::Expected<int> run(const Options& o) {
  auto context = gl::Context::create_offscreen({.platform = o.platform});
  if (!context) return tl::unexpected(context.error());
  std::FILE* out = apps::table_stream(o.csv == "-" ? o.csv : o.json);
  return o.model.files.empty() ? measure_kinds(o, *context, out) : measure_models(o, *context, out);
}

}  // namespace
}  // namespace sightline::bench::error_time_bench

sightline::bench::Run sightline::bench::add_error_time(apps::CommandLine& line) {
  using namespace error_time_bench;
  return add_subcommand<Options>(line, add_options, run);
}
