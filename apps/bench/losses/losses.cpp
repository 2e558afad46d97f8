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

#include "sightline/apps/bench/harness.h"
#include "sightline/apps/bench/losses/bound_tightness.h"
#include "sightline/apps/bench/losses/subject.h"
#include "sightline/apps/bench/renderer.h"
#include "sightline/apps/bench/subcommands.h"
#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/model.h"
#include "sightline/apps/common/output.h"
#include "sightline/apps/common/progress.h"
#include "sightline/apps/common/statistics.h"
#include "sightline/apps/common/svg_plot.h"
#include "sightline/core/camera_path.h"
#include "sightline/core/internal/srgb.h"
#include "sightline/engine/drawing/internal/drawing.h"
#include "sightline/engine/tour.h"
#include "sightline/importers/json/internal/json.h"
#include "sightline/importers/recognise/internal/recognise.h"

namespace sightline::bench::losses_bench {
namespace {

using Json = json::Value;

constexpr int kFiner = 8;  // of the reference, along each axis

struct Options {
  apps::ModelOptions model;
  std::uint64_t items = 0;
  int frames = 12, passes = 3;
  double step = 1.0 / 60.0;
  gl::ContextPlatform platform = {};
  std::string size = "640x360", json, plot;
  std::vector<std::string> rules;
};

/// `rules`: the default.
void add_options(apps::CommandLine& line, Options& o, const std::vector<std::string>& rules) {
  apps::add_model_options(line, o.model);
  const apps::Option items =
      line.add("--items", o.items, "Instead of models: a generated plant of so many items").in_range(1000, 10'000'000);
  line.option("MODEL").required(false).excludes(items);
  line.check([&o]() -> core::Expected<void> {
    if (o.model.files.empty() && o.items == 0) return core::fail("MODEL or --items is required");
    return {};
  });
  add_frames_option(line, o.frames, 1);
  line.add("--step", o.step, "Seconds of the tour between the two images that show flicker")
      .accepted_by(apps::parse_finite)
      .in_range(1e-6, 1.0)
      .shows_default();
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
  line.add("--plot", o.plot, "Write plots of error and flicker against time to PREFIX-….svg");
  apps::add_context_option(line, o.platform);
  apps::add_json_option(line, o.json);
}

void add_contribution_options(apps::CommandLine& line, Options& o) {
  add_options(line, o, {"drop", "points", "stochastic", "box", "osg", "occt", "sphere"});
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

// --- images --------------------------------------------------------------------------------------------------------

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

/// By how much a channel changes more than in the reference, mean, in 255ths.
double flicker(const std::array<image::Image, 2>& images, const std::array<image::Image, 2>& reference) {
  double sum = 0.0;
  for (std::size_t i = 0; i < images[0].pixels.size(); ++i) {
    const int change = std::abs(int(images[1].pixels[i]) - int(images[0].pixels[i]));
    const int right = std::abs(int(reference[1].pixels[i]) - int(reference[0].pixels[i]));
    sum += std::max(0, change - right);
  }
  return sum / double(images[0].pixels.size());
}

// --- forms of the model --------------------------------------------------------------------------------------------

/// The model, and what other rules draw in its place.
class Forms {
 public:
  /// `rules` loses those that mean nothing for this model. The scene must outlive the result.
  static core::Expected<Forms> create(core::Scene& scene, const Subject::Config& config, std::vector<Rule>& rules) {
    Forms forms;
    auto model = Subject::create(scene, config);
    if (!model) return tl::unexpected(model.error());
    forms.model_ = std::move(*model);
    if (!forms.model_->has_levels()) std::erase_if(rules, [](const Rule& rule) { return rule.moves_surfaces(); });
    if (uses(rules, Rule::Measure::kChain)) {
      forms.level_chain_ = std::make_unique<LevelChain>(scene);
      auto chain = Subject::create(forms.level_chain_->scene(), config, forms.level_chain_.get());
      if (!chain) return tl::unexpected(chain.error());
      forms.chain_ = std::move(*chain);
    }
    if (!uses(rules, Rule::Measure::kPrimitives)) return forms;
    if (!forms.recognise(scene)) {
      std::erase_if(rules, [](const Rule& rule) { return rule.measure == Rule::Measure::kPrimitives; });
      return forms;
    }
    auto primitives = Subject::create(*forms.recognised_, config);
    if (!primitives) return tl::unexpected(primitives.error());
    forms.primitives_ = std::move(*primitives);
    return forms;
  }

  Subject& model() { return *model_; }
  Subject& of(const Rule& rule) {
    if (rule.measure == Rule::Measure::kChain) return *chain_;
    return rule.measure == Rule::Measure::kPrimitives ? *primitives_ : *model_;
  }
  /// As Subject::shown() has it.
  const std::vector<core::ItemId>& originals(const Rule& rule) const {
    if (rule.measure == Rule::Measure::kChain) return level_chain_->originals();
    return rule.measure == Rule::Measure::kPrimitives ? of_recognised_ : none_;
  }

 private:
  static bool uses(const std::vector<Rule>& rules, Rule::Measure measure) {
    return std::ranges::find(rules, measure, &Rule::measure) != rules.end();
  }

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

// --- measuring -----------------------------------------------------------------------------------------------------

using ViewPair = std::array<core::View, 2>;

/// One value for each frame.
struct Figures {
  Rule rule;
  std::vector<double> flip_mean = {}, flip_p99 = {}, wrong_ids = {}, flicker = {}, items = {}, splats = {},
                      triangles = {}, ms = {}, processor_ms = {};
  std::vector<double> bound = {};                           // pixels, proven
  std::vector<double> surface_mean = {}, surface_p99 = {};  // pixels
  std::vector<double> tightness = {};                       // of some groups of each frame
};

/// The full image with 64 samples a pixel, and what the full image with one shows.
struct Reference {
  std::array<image::Image, 2> images;
  image::ItemDepths surface;  // of the first view
  apps::DrawnImage full;      // the first of the images, with the items and depths of the full image
};

core::Expected<std::vector<ViewPair>> views_of(const core::Scene& scene, const Options& o, double aspect) {
  const core::Snapshot snapshot(scene);
  const core::CameraPath path = engine::make_tour(snapshot.bounds(), snapshot.bounds().fitted_bounds());
  std::vector<ViewPair> views;
  for (int i = 0; i < o.frames; ++i) {
    const double time = std::min(path.time_of(i, std::max(2, o.frames)), path.end() - o.step);
    auto first = path.view(time, aspect), second = path.view(time + o.step, aspect);
    if (!first || !second) return tl::unexpected((first ? second : first).error());
    views.push_back({std::move(*first), std::move(*second)});
  }
  return views;
}

core::Expected<Reference> draw_reference(Subject& subject, const ViewPair& views, int width, int height) {
  Reference reference;
  if (auto done = subject.engine().resize(kFiner * width, kFiner * height); !done) return tl::unexpected(done.error());
  for (std::size_t i = 2; i-- > 0;) {
    if (auto ms = subject.draw({}, views[i]); !ms) return tl::unexpected(ms.error());
    auto fine = subject.image(views[i], {});
    if (!fine) return tl::unexpected(fine.error());
    reference.images[i] = reduced(fine->colour);
    reference.surface = std::move(*fine);
  }
  if (auto done = subject.engine().resize(width, height); !done) return tl::unexpected(done.error());
  return reference;
}

/// Adds how far what the last image shows lies from the reference, and what is proved of that.
core::Expected<void> compare_surfaces(Subject& subject, const core::View& view, const image::ItemDepths& shown,
                                      const Reference& reference, Figures& figures) {
  const auto loss = subject.engine().loss(view);
  if (!loss) return tl::unexpected(loss.error());
  figures.bound.push_back(loss->lod_error);
  const double radius = 4.0 + 2.0 * figures.rule.threshold;
  const apps::Summary errors = apps::summarise(surface_errors(view, reference.surface, kFiner, shown, radius));
  figures.surface_mean.push_back(errors.mean);
  figures.surface_p99.push_back(errors.p99);
  if (figures.rule.measure != Rule::Measure::kLevels) return {};
  const engine::Engine& engine = subject.engine();
  for (const double ratio :
       bound_tightness(view, engine.config().width, engine.config().height, figures.rule.threshold, engine.snapshot(),
                       subject.visible(), subject.engine().drawing()->scene().meshes()))
    figures.tightness.push_back(ratio);
  return {};
}

/// Adds the errors of one frame. The full image's own rule comes first and sets Reference::full.
core::Expected<void> compare(Forms& forms, const ViewPair& views, bool surfaces, Reference& reference,
                             Figures& figures) {
  Subject& subject = forms.of(figures.rule);
  std::array<apps::DrawnImage, 2> images;
  for (std::size_t i = 0; i < 2; ++i) {
    if (auto ms = subject.draw_again(figures.rule, views[i]); !ms) return tl::unexpected(ms.error());
    auto image = subject.image(views[i], forms.originals(figures.rule));
    if (!image) return tl::unexpected(image.error());
    images[i] = std::move(*image);
    if (i > 0) continue;
    figures.items.push_back(double(subject.counts().items_drawn));
    figures.splats.push_back(double(subject.counts().splats));
    figures.triangles.push_back(double(subject.counts().triangles));
    if (surfaces)
      if (auto done = compare_surfaces(subject, views[0], images[0], reference, figures); !done) return done;
  }
  if (figures.rule.measure == Rule::Measure::kNone) reference.full = {images[0], reference.images[0]};
  const auto errors = apps::image_errors(reference.full, images[0]);
  if (!errors) return tl::unexpected(errors.error());
  figures.flip_mean.push_back(errors->flip_mean);
  figures.flip_p99.push_back(errors->flip_p99);
  figures.wrong_ids.push_back(errors->wrong_share);
  figures.flicker.push_back(flicker({images[0].colour, images[1].colour}, reference.images));
  return {};
}

/// Adds the median of the passes in turns.
core::Expected<void> time_in_turns(Forms& forms, const core::View& view, int passes, std::vector<Figures>& all) {
  const auto samples = apps::in_turns(
      all.size(), passes, 0, [&](std::size_t i) { return forms.of(all[i].rule).draw_again(all[i].rule, view); });
  if (!samples) return tl::unexpected(samples.error());
  for (std::size_t i = 0; i < all.size(); ++i) {
    std::vector<double> ms, processor;
    for (const Took& took : (*samples)[i]) ms.push_back(took.ms), processor.push_back(took.processor_ms);
    all[i].ms.push_back(apps::median(std::move(ms)));
    all[i].processor_ms.push_back(apps::median(std::move(processor)));
  }
  return {};
}

core::Expected<std::vector<Figures>> measure(Forms& forms, const std::vector<ViewPair>& views,
                                             const std::vector<Rule>& rules, const Options& o) {
  const auto [width, height] = *apps::parse_size(o.size);
  apps::Progress progress("measuring", views.size());
  const bool surfaces = std::ranges::any_of(rules, &Rule::moves_surfaces);
  std::vector<Figures> all;
  for (const Rule& rule : rules) all.push_back({rule});
  for (std::size_t i = 0; i < views.size(); ++i) {
    auto reference = draw_reference(forms.model(), views[i], width, height);
    if (!reference) return tl::unexpected(reference.error());
    for (Figures& figures : all)
      if (auto done = compare(forms, views[i], surfaces, *reference, figures); !done)
        return tl::unexpected(done.error());
    if (auto done = time_in_turns(forms, views[i][0], o.passes, all); !done) return tl::unexpected(done.error());
    progress.advance(i + 1);
  }
  return all;
}

// --- report --------------------------------------------------------------------------------------------------------

double mean(const std::vector<double>& values) {
  return apps::summarise(values).mean;
}

Json to_json(const Figures& f) {
  Json json = {{"rule", name_of(f.rule)},
               {"threshold", f.rule.threshold},
               {"flip", {{"mean", mean(f.flip_mean)}, {"p99", mean(f.flip_p99)}}},
               {"wrong_ids", mean(f.wrong_ids)},
               {"flicker", mean(f.flicker)},
               {"items", mean(f.items)},
               {"splats", mean(f.splats)},
               {"triangles", mean(f.triangles)},
               {"ms", {{"mean", mean(f.ms)}, {"median", apps::median(f.ms)}, {"frames", f.ms}}},
               {"processor_ms", {{"mean", mean(f.processor_ms)}, {"frames", f.processor_ms}}}};
  if (!f.bound.empty())
    json["surface_px"] = {{"mean", mean(f.surface_mean)},
                          {"p99", mean(f.surface_p99)},
                          {"bound", f.bound},
                          {"tightness", apps::to_json(apps::summarise(f.tightness))}};
  return json;
}

/// A table that is also Markdown. Where surfaces move, with their errors in place of the figures of items.
void print(const std::vector<Figures>& all, std::FILE* out) {
  const bool surfaces = !all.front().bound.empty();
  std::fprintf(out,
               "| rule              | threshold, px | processor ms | ms, mean | first frame | FLIP, mean |    p99 | "
               "wrong ids, %% | flicker | %s |\n"
               "| ----------------- | ------------: | -----------: | -------: | ----------: | ---------: | -----: | "
               "-----------: | ------: | %s |\n",
               surfaces ? "triangles | surface, px |    p99 |  bound | bound / measured" : "  items |  splats",
               surfaces ? "--------: | ----------: | -----: | -----: | ---------------:" : "------: | ------:");
  for (const Figures& f : all) {
    std::fprintf(out, "| %-17s | %13.4g | %12.1f | %8.1f | %11.1f | %10.5f | %6.4f | %12.2f | %7.3f | ",
                 name_of(f.rule).c_str(), f.rule.threshold, mean(f.processor_ms), mean(f.ms), f.ms.front(),
                 mean(f.flip_mean), mean(f.flip_p99), 100.0 * mean(f.wrong_ids), mean(f.flicker));
    if (surfaces)
      std::fprintf(out, "%9.0f | %11.4f | %6.3f | %6.2f | %16.2f |\n", mean(f.triangles), mean(f.surface_mean),
                   mean(f.surface_p99), mean(f.bound), apps::summarise(f.tightness).median);
    else
      std::fprintf(out, "%7.0f | %7.0f |\n", mean(f.items), mean(f.splats));
  }
}

/// The full image is a line: rules need not go below its error.
core::Expected<void> write_plot(const std::vector<Figures>& all, const std::string& model, const std::string& file,
                                const std::string& label, std::vector<double> Figures::*figure) {
  using apps::PanelSeries;
  apps::Panel panel{model, {}};
  double least = mean(all.front().processor_ms), most = least;
  for (const Figures& f : all) {
    least = std::min(least, mean(f.processor_ms));
    most = std::max(most, mean(f.processor_ms));
  }
  const double floor = mean(all.front().*figure);
  panel.series.push_back(
      {"full image, one sample", {{least, floor, ""}, {most, floor, ""}}, PanelSeries::Style::kDashes});
  for (const Figures& f : all) {
    if (f.rule.measure == Rule::Measure::kNone) continue;
    const std::string name = name_of(f.rule);
    if (panel.series.back().label != name) panel.series.push_back({name, {}});
    char threshold[32];
    std::snprintf(threshold, sizeof threshold, "%.4g", f.rule.threshold);
    panel.series.back().points.push_back({mean(f.processor_ms), mean(f.*figure), threshold});
  }
  apps::PanelPlot plot{"Error against time", "processor time a frame, ms", label, {std::move(panel)}};
  plot.large = true;
  return apps::write_text(file, apps::svg_panels(plot));
}

core::Expected<int> run(const Options& o) {
  const auto made = model_or_plant(o.model, o.items);
  if (!made) return tl::unexpected(made.error());
  core::Scene& scene = **made;
  std::string name = o.items > 0 ? "generated plant of " + engine::count_text(o.items) : "";
  for (const std::string& file : o.model.files)
    name += (name.empty() ? "" : ", ") + std::filesystem::path(file).filename().string();
  const auto [width, height] = *apps::parse_size(o.size);
  const auto views = views_of(scene, o, double(width) / height);
  if (!views) return tl::unexpected(views.error());
  std::vector<Rule> rules = rules_of(o.rules);
  auto forms = Forms::create(scene, {width, height, o.platform}, rules);
  if (!forms) return tl::unexpected(forms.error());
  const gl::Context& context = forms->model().engine().drawing()->context();
  std::FILE* out = apps::table_stream(o.json);
  std::fprintf(out, "%s, %s, %d frames of the tour, %s\n\n", name.c_str(), o.size.c_str(), o.frames,
               renderer_line(context).c_str());
  Json json = renderer_json(context);
  json.update({{"model", name}, {"size", o.size}, {"frames", o.frames}, {"step_s", o.step}, {"passes", o.passes}});
  const auto all = measure(*forms, *views, rules, o);
  if (!all) return tl::unexpected(all.error());
  print(*all, out);
  for (const Figures& f : *all) json["rules"].push_back(to_json(f));
  if (!o.plot.empty()) {
    auto done = write_plot(*all, name, o.plot + "-flip.svg", "FLIP, mean", &Figures::flip_mean);
    if (done) done = write_plot(*all, name, o.plot + "-flicker.svg", "flicker, 255ths", &Figures::flicker);
    if (!done) return tl::unexpected(done.error());
  }
  return finish(o.json, json);
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
