// sightline-bench contribution and lod: error of the image against the time of a frame, for rules that draw it with
// less than all there is: contribution begins with those that leave out small items, lod with those for meshes.
//
// Frames of the automatic tour are drawn with each rule and threshold. The reference is the full image with 64
// samples per pixel: eight times as wide and high, averaged in linear light. The full image of one sample per pixel
// has an error, too, which no rule need go below.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "sightline/apps/bench/error_time/comparison.h"
#include "sightline/apps/bench/harness.h"
#include "sightline/apps/bench/losses/bound_tightness.h"
#include "sightline/apps/bench/losses/subject.h"
#include "sightline/apps/bench/renderer.h"
#include "sightline/apps/bench/subcommands.h"
#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/need.h"
#include "sightline/apps/common/statistics.h"
#include "sightline/apps/common/table.h"
#include "sightline/core/internal/srgb.h"
#include "sightline/engine/drawing/internal/drawing.h"
#include "sightline/engine/internal/engine_parts.h"
#include "sightline/importers/json/internal/json.h"
#include "sightline/importers/recognise/internal/recognise.h"

namespace sightline::bench::losses_bench {
namespace {

using apps::need;
using Json = json::Value;

constexpr int kFiner = 8;  // of the reference, along each axis

struct Options {
  ModelOrPlant model;
  int frames = 12, passes = 3;
  gl::ContextPlatform platform = {};
  std::string size = "640x360", json, plot;
  std::vector<std::string> rules;
};

/// `rules`: the default.
void add_options(apps::CommandLine& line, Options& o, const std::vector<std::string>& rules) {
  add_model_or_plant_options(line, o.model);
  add_frames_option(line, o.frames, 1);
  line.add("--passes", o.passes, "Of which the median time counts").in_range(1, 1000).shows_default();
  line.add("--size", o.size, "Pixels; the reference is eight times as wide and high")
      .shows_default()
      .accepted_by(apps::parse_size);
  o.rules = rules;
  line.add("--rules", o.rules, "What is measured beside the full image")
      .separated_by(',')
      .one_value_each()
      .one_of(rule_names())
      .shows_default();
  line.add("--plot", o.plot, "Write a plot of error against time to PREFIX-flip.svg");
  apps::add_context_option(line, o.platform);
  apps::add_json_option(line, o.json);
}

void add_contribution_options(apps::CommandLine& line, Options& o) {
  add_options(line, o, {"drop", "points", "stochastic", "box", "osg", "occt"});
  line.examples(
      "  sightline-bench contribution --items 100000 --plot plant --json plant.json\n"
      "  sightline-bench contribution plant.rvm --frames 24 --size 1280x720");
}

void add_lod_options(apps::CommandLine& line, Options& o) {
  add_options(line, o, {"drop", "levels", "chain", "primitives"});
  line.examples(
      "  sightline-bench lod ship.glb --plot ship --json ship.json\n"
      "  sightline-bench lod scan.ply --frames 4 --rules levels,chain");
}

/// The mean of kFiner x kFiner pixels each, in linear light.
image::Image reduced(const image::Image& fine) {
  const std::array<double, 256> linear = core::linear_from_bytes();
  image::Image image{fine.width / kFiner, fine.height / kFiner, {}};
  image.pixels.reserve(std::size_t(image.width) * std::size_t(image.height) * 3);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (int c = 0; c < 3; ++c) {
        double sum = 0.0;
        for (int j = 0; j < kFiner; ++j)
          for (int i = 0; i < kFiner; ++i)
            sum += linear[fine.pixels[std::size_t(((kFiner * y + j) * fine.width + kFiner * x + i) * 3 + c)]];
        sum /= double(kFiner * kFiner);
        image.pixels.push_back(std::uint8_t(std::lround(255.0 * core::srgb_from_linear(sum))));
      }
  return image;
}

/// The model, and what other rules draw in its place.
class Forms {
 public:
  /// `rules` loses those that mean nothing for this model. The scene must outlive this.
  Forms(core::Scene& scene, const Subject::Config& config, std::vector<Rule>& rules)
      : model_(std::make_unique<Subject>(scene, config)) {
    if (!model_->has_levels()) std::erase_if(rules, [](const Rule& rule) { return rule.moves_surfaces(); });
    if (std::ranges::count(rules, Rule::Measure::kChain, &Rule::measure) > 0) {
      level_chain_ = std::make_unique<LevelChain>(scene);
      chain_ = std::make_unique<Subject>(level_chain_->scene(), config, level_chain_.get());
    }
    if (std::ranges::count(rules, Rule::Measure::kPrimitives, &Rule::measure) == 0) return;
    if (recognise(scene))
      primitives_ = std::make_unique<Subject>(*recognised_, config);
    else
      std::erase_if(rules, [](const Rule& rule) { return rule.measure == Rule::Measure::kPrimitives; });
  }

  Subject& model() { return *model_; }
  Subject& of(const Rule& rule) {
    if (rule.measure == Rule::Measure::kChain) return *chain_;
    return rule.measure == Rule::Measure::kPrimitives ? *primitives_ : *model_;
  }
  /// As Subject::image() takes it.
  const std::vector<core::ItemId>& originals(const Rule& rule) const {
    if (rule.measure == Rule::Measure::kChain) return level_chain_->originals();
    return rule.measure == Rule::Measure::kPrimitives ? of_recognised_ : none_;
  }

 private:
  /// Whether a primitive is found. What replaces an item counts as the first item with a mesh of the same node.
  bool recognise(const core::Scene& scene) {
    recognised_ = std::make_unique<core::Scene>(scene);
    importers::RecognitionReport report;
    importers::recognise_items(
        *recognised_, core::ItemId{0}, 0.0, [](double) { return true; }, report);
    std::map<std::uint32_t, core::ItemId> of_node;
    for (core::ItemId item{0}; to_index(item) < recognised_->item_slots(); ++item) {
      const bool old = to_index(item) < scene.item_slots(), there = recognised_->contains_item(item);
      of_recognised_.push_back(item);
      if (old && !there && scene.contains_item(item)) of_node.try_emplace(scene.node_of(item).index, item);
      if (!old && there) of_recognised_.back() = of_node.at(recognised_->node_of(item).index);
    }
    return recognised_->item_slots() > scene.item_slots();
  }

  std::unique_ptr<LevelChain> level_chain_;
  std::unique_ptr<core::Scene> recognised_;
  std::vector<core::ItemId> of_recognised_, none_;
  std::unique_ptr<Subject> model_, chain_, primitives_;
};

/// The full image, whose colours are the mean of 64 samples a pixel; `surface` gets what these show.
apps::DrawnImage draw_reference(Subject& model, const core::View& view, const Subject::Config& config,
                                image::ItemDepths& surface) {
  need(model.engine().resize(kFiner * config.width, kFiner * config.height));
  need(model.draw({}, view));
  apps::DrawnImage fine = model.image(view, {});
  need(model.engine().resize(config.width, config.height));
  need(model.draw_again({}, view));
  apps::DrawnImage full = model.image(view, {});
  full.colour = reduced(fine.colour);
  surface = std::move(fine);
  return full;
}

/// Adds how far what the last image shows lies from the reference, in pixels, and what is proved of that.
void measure_surfaces(Subject& subject, const Rule& rule, const core::View& view, const image::ItemDepths& shown,
                      const image::ItemDepths& reference, Measures& measures) {
  measures["bound"].push_back(need(subject.engine().loss(view)).lod_error);
  const double radius = 4.0 + 2.0 * rule.threshold;
  const apps::Summary errors = apps::summarise(surface_errors(view, reference, kFiner, shown, radius));
  measures["surface"].push_back(errors.mean);
  measures["surface_p99"].push_back(errors.p99);
  if (rule.measure != Rule::Measure::kLevels) return;
  const engine::EngineConfig config = subject.engine().config();
  for (const double ratio :
       bound_tightness({view, config.width, config.height, rule.threshold}, subject.engine().snapshot(),
                       subject.visible(), engine::EngineParts::drawing(subject.engine())->scene().meshes()))
    measures["tightness"].push_back(ratio);
}

constexpr apps::Column kColumns[] = {{"rule", "name"},
                                     {"threshold, px", "threshold"},
                                     {"processor ms", "processor_ms/mean", "{:.1f}"},
                                     {"ms, mean", "ms/mean", "{:.1f}"},
                                     {"FLIP, mean", "flip/mean", "{:.5f}"},
                                     {"p99", "flip_p99/mean", "{:.4f}"},
                                     {"wrong ids, %", "wrong_ids/mean", "{:.2f}"},
                                     {"items", "items/mean", "{:.0f}"},
                                     {"splats", "splats/mean", "{:.0f}"},
                                     {"triangles", "triangles/mean", "{:.0f}"},
                                     {"surface, px", "surface/mean", "{:.4f}"},
                                     {"p99", "surface_p99/mean", "{:.3f}"},
                                     {"bound", "bound/mean", "{:.2f}"},
                                     {"bound / measured", "tightness/median", "{:.2f}"}};

core::Expected<int> run(const Options& o) {
  const std::unique_ptr<core::Scene> scene = need(model_or_plant(o.model.model, o.model.items));
  std::string name = o.model.items > 0 ? "generated plant of " + engine::count_text(o.model.items) : "";
  for (const std::string& file : o.model.model.files)
    name += (name.empty() ? "" : ", ") + std::filesystem::path(file).filename().string();
  const auto [width, height] = need(apps::parse_size(o.size));
  const auto views = need(tour_views(core::Snapshot(*scene), o.frames, double(width) / height));
  const Subject::Config config{width, height, o.platform};
  std::vector<Rule> rules = rules_of(o.rules);
  Forms forms(*scene, config, rules);
  const bool surfaces = std::ranges::any_of(rules, &Rule::moves_surfaces);
  image::ItemDepths surface;  // of the view that is compared
  std::vector<Way> ways;
  for (const Rule& rule : rules)
    ways.push_back({name_of(rule), rule.threshold,
                    [&](const core::View& view) { return forms.of(rule).draw_again(rule, view); },
                    [&](const core::View& view, Measures& measures) {
                      Subject& subject = forms.of(rule);
                      apps::DrawnImage image = subject.image(view, forms.originals(rule));
                      measures["items"].push_back(double(subject.counts().items_drawn));
                      measures["splats"].push_back(double(subject.counts().splats));
                      measures["triangles"].push_back(double(subject.counts().triangles));
                      if (surfaces) measure_surfaces(subject, rule, view, image, surface, measures);
                      return image;
                    }});
  const Json rows = compare(ways, views, o.passes, [&](const core::View& view) {
    return draw_reference(forms.model(), view, config, surface);
  });
  if (!o.plot.empty()) {
    const ErrorPlot plot{o.plot + "-flip.svg",         "Error against time", "processor_ms/mean",
                         "processor time a frame, ms", "flip/mean",          "FLIP, mean"};
    need(write_plot(plot, {panel_of(name, rows, plot)}));
  }
  const gl::Context& context = engine::EngineParts::drawing(forms.model().engine())->context();
  Json json = renderer_json(context);
  json.update({{"model", name}, {"size", o.size}, {"frames", o.frames}, {"passes", o.passes}, {"rules", rows}});
  return finish(o.json, json, [&](const Json&, std::FILE* out) {
    std::fprintf(out, "%s, %s, %d frames of the tour, %s\n\n", name.c_str(), o.size.c_str(), o.frames,
                 renderer_line(context).c_str());
    apps::print_table(rows, kColumns, out);
  });
}

}  // namespace
}  // namespace sightline::bench::losses_bench

sightline::bench::Run sightline::bench::add_contribution(apps::CommandLine& line) {
  using namespace losses_bench;
  return add_subcommand<Options>(line, add_contribution_options, run);
}

sightline::bench::Run sightline::bench::add_lod(apps::CommandLine& line) {
  using namespace losses_bench;
  return add_subcommand<Options>(line, add_lod_options, run);
}
