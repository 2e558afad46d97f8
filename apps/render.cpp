// sightline-render: one image of a model, and a comparison that makes it a regression test.

#include <cstdio>
#include <fstream>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "sightline/apps/common/blank.h"
#include "sightline/apps/common/style_options.h"
#include "sightline/apps/common/view_options.h"
#include "sightline/engine/engine.h"
#include "sightline/image/image_metrics.h"

namespace {

using namespace sightline;
using nlohmann::json;

struct Options {
  apps::ModelOptions model;
  apps::ViewOptions view;
  std::string out, ids, ids_json, depth, reference, reference_ids, diff, json_file;
  engine::CullerChoice culler = engine::CullerChoice::kAutomatic;
  culling::GpuCullerConfig gpu_culler;
  int samples = 1;
  apps::ShownOptions shown;
  apps::StyleOptions styles;
  gl::ContextPlatform platform = {};
  bool gl_debug = false;
  double max = -1.0, mean = -1.0, pixels_per_degree = image::kPixelsPerDegree;
};

void add_options(CLI::App& app, Options& o) {
  apps::add_model_options(app, o.model);
  apps::add_view_options(app, o.view);
  app.add_option("--out", o.out, "Colour image, PNG");
  app.add_option("--ids", o.ids, "Item-id image, PNG: item + 1 in 24 bits, R lowest, 0 background");
  app.add_option("--ids-json", o.ids_json, "Node path and kind of each item in the id image, JSON");
  app.add_option("--depth", o.depth, "Depth image, PFM: metres along the view axis");
  auto* compare = app.add_option("--compare", o.reference,
                                 "Reference PNG; exit 1 when the image differs by more than --max or --mean. Prints "
                                 "PSNR, SSIM and FLIP too");
  app.add_option("--max", o.max, "Largest allowed difference of a channel, 0 to 255 (default 0, or any with --mean)")
      ->needs(compare)
      ->check(CLI::Range(0.0, 255.0))
      ->check(apps::accepted_by(apps::parse_finite));
  app.add_option("--mean", o.mean, "Largest allowed mean difference, 0 to 255 (default 0, or any with --max)")
      ->needs(compare)
      ->check(CLI::Range(0.0, 255.0))
      ->check(apps::accepted_by(apps::parse_finite));
  app.add_option("--pixels-per-degree", o.pixels_per_degree, "Of the visual field, for FLIP")
      ->needs(compare)
      ->capture_default_str()
      ->check(CLI::Range(1.0, 1000.0));
  app.add_option("--compare-ids", o.reference_ids, "Reference of --ids, PNG: counts the pixels that show another item");
  app.add_option("--diff", o.diff, "Difference image, PNG, four times amplified")->needs(compare);
  apps::add_culler_option(app, o.culler);
  apps::add_gpu_pass_option(app, o.gpu_culler);
  apps::add_shown_options(app, o.shown);
  apps::add_style_options(app, o.styles);
  app.add_option("--samples", o.samples, "Per pixel, for smooth edges; ids and depth are then one sample's")
      ->capture_default_str()
      ->check(CLI::Range(1, 64));
  apps::add_context_option(app, o.platform);
  app.add_flag("--gl-debug", o.gl_debug, "Fail on any message of the GL driver");
  app.add_option("--json", o.json_file, "Write figures as JSON to FILE, or - for stdout");
}

core::Expected<void> write_id_names(const std::string& file, const image::IdImage& ids, const core::Scene& scene) {
  std::vector<std::uint32_t> seen = ids.ids;
  std::sort(seen.begin(), seen.end());
  seen.erase(std::unique(seen.begin(), seen.end()), seen.end());
  json out = json::object();
  for (const std::uint32_t id : seen) {
    if (id == 0) continue;
    const core::ItemId item = id - 1;
    out[std::to_string(item)] = {{"node", scene.path(scene.node_of(item))},
                                 {"kind", std::string(core::name_of(scene.kind(item)))}};
  }
  return apps::write_text(file, apps::to_text(out));
}

/// Adds measures of how visible the difference is. Images that are too small have none.
void add_metrics(const Options& o, const image::Image& reference, const image::Image& image, json& figures) {
  const auto metrics = image::image_metrics(reference, image, o.pixels_per_degree);
  if (!metrics) return;
  figures["psnr"] = metrics->psnr;
  figures["ssim"] = metrics->ssim;
  figures["flip"] = {{"mean", metrics->flip_mean}, {"p99", metrics->flip_p99}};
  std::fprintf(apps::table_stream(o.json_file), "PSNR %.2f dB  SSIM %.5f  FLIP mean %.5f, p99 %.4f\n", metrics->psnr,
               metrics->ssim, metrics->flip_mean, metrics->flip_p99);
}

core::Expected<bool> compare(const Options& o, const image::Image& image, json& figures) {
  auto reference = image::read_png(o.reference);
  if (!reference) return tl::unexpected(reference.error());
  auto difference = image::compare(image, *reference);
  if (!difference) return core::fail(o.reference + ": " + difference.error().message);
  if (!o.diff.empty())
    if (auto done = image::write_png(image::difference_image(image, *reference), o.diff); !done)
      return tl::unexpected(done.error());
  const bool only_mean = o.max < 0.0 && o.mean >= 0.0, only_max = o.mean < 0.0 && o.max >= 0.0;
  const bool same =
      (only_mean || difference->max <= std::max(0.0, o.max)) && (only_max || difference->mean <= std::max(0.0, o.mean));
  figures["compare"] = {
      {"max", difference->max}, {"mean", difference->mean}, {"pixels", difference->pixels}, {"ok", same}};
  add_metrics(o, *reference, image, figures["compare"]);
  std::fprintf(apps::table_stream(o.json_file), "max %d  mean %.4f  differing pixels %llu  %s\n", difference->max,
               difference->mean, (unsigned long long)difference->pixels, same ? "ok" : "DIFFERS");
  return same;
}

core::Expected<void> compare_ids(const Options& o, engine::Engine& engine, json& figures) {
  auto reference = image::read_png(o.reference_ids);
  if (!reference) return tl::unexpected(reference.error());
  const auto ids = engine.read_ids();
  if (!ids) return tl::unexpected(ids.error());
  const auto wrong = image::wrong_ids(image::ids_of_colours(*reference), *ids);
  if (!wrong) return core::fail(o.reference_ids + ": " + wrong.error().message);
  figures["wrong_ids"] = *wrong;
  std::fprintf(apps::table_stream(o.json_file), "pixels of another item %llu\n", (unsigned long long)*wrong);
  return {};
}

core::Expected<void> write_outputs(const Options& o, engine::Engine& engine, const core::View& view,
                                   const core::Scene& scene, const image::Image& image) {
  core::Expected<void> done;
  if (!o.out.empty()) done = image::write_png(image, o.out);
  if (done && !o.depth.empty()) {
    const auto depth = engine.read_depth(view);
    if (!depth) return tl::unexpected(depth.error());
    done = image::write_pfm(*depth, o.depth);
  }
  if (!done || (o.ids.empty() && o.ids_json.empty())) return done;
  const auto ids = engine.read_ids();
  if (!ids) return tl::unexpected(ids.error());
  if (!o.ids.empty()) {
    auto colours = image::id_colours(*ids);
    if (!colours) return tl::unexpected(colours.error());
    done = image::write_png(*colours, o.ids);
  }
  if (done && !o.ids_json.empty()) done = write_id_names(o.ids_json, *ids, scene);
  return done;
}

core::Expected<int> render_model(const Options& o) {
  const auto size = apps::parse_size(o.view.size);
  if (!size) return tl::unexpected(size.error());
  auto model = apps::load_model(o.model);
  if (!model) return tl::unexpected(model.error());
  engine::EngineConfig config;
  config.draw = true;
  config.width = (*size)[0];
  config.height = (*size)[1];
  config.samples = o.samples;
  o.shown.apply(config);
  config.transparency = o.styles.transparency;
  config.ids = !o.ids.empty() || !o.ids_json.empty() || !o.reference_ids.empty();
  config.context_platform = o.platform;
  config.gl_debug = o.gl_debug;
  config.culler = o.culler;
  config.gpu_culler = o.gpu_culler;
  auto engine = engine::Engine::create(*model->scene, config);
  if (!engine) return tl::unexpected(engine.error());
  if (o.model.explain) apps::explain(engine->plan());
  if (auto done = apps::apply_styles(o.styles, *model->scene, *engine); !done) return tl::unexpected(done.error());

  auto view = apps::choose_view(o.view, *model, engine->snapshot(), double(config.width) / config.height);
  if (!view) return tl::unexpected(view.error());
  auto report = engine->frame(*view);
  if (!report) return tl::unexpected(report.error());
  if (!report->drawn) return core::fail("the GL context was lost before the image was drawn");
  engine->finish();
  if (const auto late = engine->take_late_report()) report->visible = late->visible;
  for (const std::string& error : engine->take_gl_errors()) return core::fail("GL: " + error);

  apps::warn_if_blank(*engine, report->visible, "the image");
  const auto image = engine->read_colour();
  if (!image) return tl::unexpected(image.error());
  if (auto done = write_outputs(o, *engine, *view, *model->scene, *image); !done) return tl::unexpected(done.error());
  json figures = {{"renderer", engine->renderer()},
                  {"size", {config.width, config.height}},
                  {"items", engine->snapshot().size()},
                  {"visible", report->visible},
                  {"sampled", report->sampled},
                  {"shown", report->shown},
                  {"small", report->small},
                  {"pending", report->pending},
                  {"squares", report->squares},
                  {"tested", report->tested},
                  {"culler", name_of(engine->plan().culler)}};
  if (!o.reference_ids.empty())
    if (auto done = compare_ids(o, *engine, figures); !done) return tl::unexpected(done.error());
  bool same = true;
  if (!o.reference.empty()) {
    auto compared = compare(o, *image, figures);
    if (!compared) return tl::unexpected(compared.error());
    same = *compared;
  }
  if (auto done = apps::write_json(o.json_file, figures); !done) return tl::unexpected(done.error());
  return same ? apps::kExitOk : apps::kExitFailure;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Renders one image of a model offscreen; with --compare a regression test", "sightline-render");
  apps::describe(
      app,
      "  sightline-render plant.rvm --out plant.png\n"
      "  sightline-render plant.rvm --view view.json --size 640x360 --out a.png --depth a.pfm --ids ids.png\n"
      "  sightline-render plant.rvm --view view.json --compare reference.png --max 8 --mean 0.1 --diff d.png\n"
      "  sightline-render plant.rvm --highlight PS-100 --ghost-others PS-100 --out selected.png");
  Options options;
  add_options(app, options);
  return apps::run(app, argc, argv, [&] { return render_model(options); });
}
