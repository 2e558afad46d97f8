// sightline-bench error-time: the cost and the errors of triangles and of ray-cast GLSL in place of them.
//
// Without a model: measures each kind separately, with random items 1/16 and 6/10 as large as the image's height.
// Depth, normal and silhouette errors are against the C++ intersections in double. With models: compares whole images
// with those of triangles so small that no pixel shows them. Everything compared is timed in turns.
#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>

#include "sightline/apps/bench/error_time/comparison.h"
#include "sightline/apps/bench/error_time/kinds.h"
#include "sightline/apps/bench/harness.h"
#include "sightline/apps/bench/renderer.h"
#include "sightline/apps/bench/subcommands.h"
#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/model.h"
#include "sightline/apps/common/need.h"
#include "sightline/apps/common/progress.h"
#include "sightline/apps/common/table.h"
#include "sightline/apps/common/tessellated_scene.h"
#include "sightline/engine/tour.h"
#include "sightline/importers/view_json.h"

namespace sightline::bench::error_time_bench {
namespace {

using apps::need;
using Json = json::Value;
namespace fs = std::filesystem;

struct Options {
  apps::ModelOptions model;
  std::vector<std::string> only;
  std::vector<int> segments{6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 256};
  std::string size, views, plot, json;
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
  line.add("--plot", o.plot, "Write plots to PREFIX-….svg");
  apps::add_context_option(line, o.platform);
  apps::add_json_option(line, o.json);
  line.examples(
      "  sightline-bench error-time --plot kinds --json kinds.json\n"
      "  sightline-bench error-time --only circular_torus,sphere --segments 12,24,48 --passes 15\n"
      "  sightline-bench error-time plant.rvm --plot plant\n"
      "  sightline-bench error-time PIPES.RVM STEEL.RVM --views views/ --reference 256");
}

/// Rows of all that was measured, and the panels of each plot.
struct Results {
  std::vector<ErrorPlot> plots;
  Json rows = Json::array();
  std::vector<std::vector<apps::Panel>> panels{plots.size()};

  /// `facts`: members that the rows get in front.
  void add(const std::string& title, const Json& facts, const Json& measured) {
    for (const Json& row : measured) {
      rows.push_back(facts);
      rows[rows.size() - 1].update(row);
    }
    for (std::size_t i = 0; i < plots.size(); ++i) {
      apps::Panel panel = panel_of(title, measured, plots[i]);
      auto& all = panels[i];
      if (all.empty() || all.back().title != title)
        all.push_back(std::move(panel));
      else
        all.back().series.insert(all.back().series.end(), panel.series.begin(), panel.series.end());
    }
  }
};

// --- kinds -----------------------------------------------------------------------------------------------------------

constexpr apps::Column kKindColumns[] = {{"kind", "primitive"},
                                         {"px", "pixels", "{:.0f}"},
                                         {"form", "form"},
                                         {"segments", "threshold", "{:.0f}"},
                                         {"ms", "ms", "{:.3g}"},
                                         {"bytes/item", "bytes_per_item", "{:.0f}"},
                                         {"silhouette, mean px", "silhouette/mean", "{:.3g}"},
                                         {"max", "silhouette/max", "{:.3g}"},
                                         {"depth, mean", "depth/mean", "{:.3g}"},
                                         {"p99", "depth/p99", "{:.3g}"},
                                         {"normal, mean °", "normal/mean", "{:.3g}"},
                                         {"p99", "normal/p99", "{:.3g}"},
                                         {"wrong samples", "wrong", "{:.0f}"},
                                         {"of", "hits", "{:.0f}"}};

Results measure_kinds(const Options& o, gl::Context& context, const std::array<int, 2>& size) {
  const double height = size[1];
  if (3 * size[0] < 4 * size[1] || size[1] < 64) apps::fail("--size: must be 4:3 or wider, and 64 high");
  const KindConfig config{size[0], size[1], o.samples, o.passes, o.seed, o.segments};
  const auto plot = [&](const char* name, const char* label) {
    return ErrorPlot{
        o.plot + "-" + name + ".svg", "Error against time", "ms", "ms per frame", name + std::string("/mean"), label};
  };
  Results results{{plot("silhouette", "silhouette error, mean, pixels"), plot("depth", "relative depth error, mean"),
                   plot("normal", "normal error, mean, degrees")}};
  for (const core::Kind kind : measured_kinds())
    for (const FieldSize& field : {FieldSize{height / 16.0, 8, 8, 1}, {0.6 * height, 2, 1, o.images}}) {
      const std::string name(core::name_of(kind)), pixels = std::to_string(int(field.pixels)) + " px";
      if (!o.only.empty() && std::ranges::find(o.only, name) == o.only.end()) continue;
      apps::show_step(name + ", " + pixels);
      Json rows = measure_kind(context, kind, field, config);
      for (Json& row : rows) {
        row["form"] = row["name"];
        row["name"] = row["form"].string() + ", " + pixels;
      }
      results.add(name, {{"primitive", name}, {"pixels", field.pixels}}, rows);
    }
  return results;
}

// --- models ----------------------------------------------------------------------------------------------------------

constexpr apps::Column kModelColumns[] = {{"model", "model"},
                                          {"view", "view"},
                                          {"form", "name"},
                                          {"segments", "threshold", "{:.0f}"},
                                          {"ms", "ms/mean", "{:.3g}"},
                                          {"GPU kB", "gpu_kb/mean", "{:.0f}"},
                                          {"PSNR", "psnr/mean", "{:.1f}"},
                                          {"SSIM", "ssim/mean", "{:.5f}"},
                                          {"FLIP, mean", "flip/mean", "{:.5f}"},
                                          {"FLIP, p99", "flip_p99/mean", "{:.4f}"},
                                          {"wrong ids but ties, %", "wrong_ids_but_ties/mean", "{:.4f}"}};

/// The views of --views; without it the whole model, and two places of the tour through it.
std::vector<std::pair<std::string, core::View>> views_of(const Options& o, const std::string& name,
                                                         const apps::Model& model, double aspect) {
  std::vector<std::pair<std::string, core::View>> views;
  if (!o.views.empty()) {
    std::map<std::string, fs::path> files;  // sorted by name
    for (const fs::directory_entry& entry : fs::directory_iterator(o.views)) {
      const std::string stem = entry.path().stem().string();
      if (entry.path().extension() == ".json" && stem.rfind(name + "_", 0) == 0)
        files.emplace(stem.substr(name.size() + 1), entry.path());
    }
    for (const auto& [view_name, file] : files)
      views.emplace_back(view_name,
                         need(importers::translated(need(importers::read_view(file, aspect)), model.offset)));
    if (views.empty()) apps::fail(o.views + ": has no view " + name + "_*.json");
    return views;
  }
  const core::Snapshot snapshot(*model.scene);
  const core::FittedBounds fitted = snapshot.bounds().fitted_bounds();
  views.emplace_back("whole", need(core::View::fit(fitted.bounds, core::kOverviewDirection, apps::kFovy, aspect)));
  const core::CameraPath tour = engine::make_tour(snapshot.bounds(), fitted);
  for (const int percent : {40, 70})
    views.emplace_back("tour at " + std::to_string(percent) + " %",
                       need(tour.view(tour.time_of(percent, 101), aspect)));
  return views;
}

/// The model as it is, or as triangles with so many segments.
std::shared_ptr<apps::DrawnVariant> variant_of(gl::Context& context, const core::Scene& scene, int segments,
                                               const std::array<int, 2>& size) {
  auto drawn = std::make_shared<core::Scene>(segments > 0 ? apps::tessellated(scene, segments) : scene);
  engine::EngineConfig config{.width = size[0], .height = size[1]};
  config.context.application = &context;
  return std::make_shared<apps::DrawnVariant>(need(apps::DrawnVariant::create(std::move(drawn), config)));
}

Way way_of(const std::shared_ptr<apps::DrawnVariant>& variant, int segments) {
  const auto draw = [variant](const core::View& view) {
    const double processor = processor_milliseconds();
    return variant->draw(view).map([&](double ms) { return Took{ms, processor_milliseconds() - processor}; });
  };
  const auto image = [variant](const core::View& view, Measures& measures) {
    measures["gpu_kb"].push_back(double(variant->gpu_bytes()) / 1024.0);
    return need(variant->image(view));
  };
  return {segments > 0 ? "triangles" : "GLSL", double(segments), draw, image};
}

Results measure_models(const Options& o, gl::Context& context, const std::array<int, 2>& size) {
  const char* title = "Error of the image against its cost";
  Results results{{{o.plot + "-time.svg", title, "ms/mean", "ms per frame", "flip/mean", "mean FLIP"},
                   {o.plot + "-bytes.svg", title, "gpu_kb/mean", "kB of GPU memory", "flip/mean", "mean FLIP"}}};
  for (const std::string& file : o.model.files) {
    apps::ModelOptions one = o.model;
    one.files = {file};
    const apps::Model model = need(apps::load_model(one));
    need(model.scene->commit());
    const std::string name = fs::path(file).stem().string();
    const auto views = views_of(o, name, model, double(size[0]) / size[1]);
    const auto reference = variant_of(context, *model.scene, o.reference, size);
    std::vector<Way> ways{way_of(variant_of(context, *model.scene, 0, size), 0)};
    for (const int segments : o.segments)
      ways.push_back(way_of(variant_of(context, *model.scene, segments, size), segments));
    const auto reference_of = [&](const core::View& view) {
      need(reference->draw(view));
      return need(reference->image(view));
    };
    for (const auto& [view_name, view] : views)
      results.add(name + ", " + view_name, {{"model", name}, {"items", model.scene->item_count()}, {"view", view_name}},
                  compare(ways, {&view, 1}, o.passes, reference_of));
  }
  return results;
}

core::Expected<int> run(const Options& o) {
  gl::Context context = need(gl::Context::create_offscreen({.platform = o.platform}));
  const bool kinds = o.model.files.empty();
  const auto size = need(apps::parse_size(!o.size.empty() ? o.size : kinds ? "640x480" : "1280x720"));
  const Results results = (kinds ? measure_kinds : measure_models)(o, context, size);
  for (std::size_t i = 0; !o.plot.empty() && i < results.plots.size(); ++i)
    need(write_plot(results.plots[i], results.panels[i]));
  Json json = renderer_json(context);
  json.update({{"size", size}, {"passes", o.passes}, {"rows", results.rows}});
  if (kinds)
    json.update({{"samples_per_pixel", o.samples}, {"seed", o.seed}});
  else
    json["reference_segments"] = o.reference;
  return finish(o.json, json, [&](const Json&, std::FILE* out) {
    std::fprintf(out, "%s, %dx%d, median of %d passes\n\n", renderer_line(context).c_str(), size[0], size[1], o.passes);
    if (kinds)
      apps::print_table(results.rows, kKindColumns, out);
    else
      apps::print_table(results.rows, kModelColumns, out);
  });
}

}  // namespace
}  // namespace sightline::bench::error_time_bench

sightline::bench::Run sightline::bench::add_error_time(apps::CommandLine& line) {
  using namespace error_time_bench;
  return add_subcommand<Options>(line, add_options, run);
}
