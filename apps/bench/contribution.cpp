// sightline-bench contribution: error of the image against the time of a frame, for rules that leave out small items,
// and for levels of detail of meshes.
//
// Frames of the automatic tour are drawn with each rule and threshold. The reference is the full image with 64
// samples per pixel: eight times as wide and high, averaged in linear light. The full image of one sample per pixel
// has an error, too, which no rule need go below.
//
// Rules:
//   solid     the engine's: area of the solid, at most of its box (culling/occlusion/contribution.h), and the
//             three ways of drawing what is below the threshold
//   box       projected area of the bounding box alone
//   osg       OpenSceneGraph 3.6, CullingSet::isCulled(BoundingSphere) and computePixelSizeVector(): the sphere's size
//             in pixels, by default 2
//   occt      Open CASCADE 7.6, Graphic3d_CullingTool::IsTooSmall(): the diagonal's length in pixels
//   sphere    projected area of the bounding sphere
//   levels    meshes by levels of detail whose proven error is at most so many pixels (lod/mesh_levels.h)
// The three before compare the diagonal with the distance, so they differ only in the scale of their thresholds.
#include "sightline/culling/occlusion/contribution.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "sightline/apps/bench/harness.h"
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
#include "sightline/culling/frustum/cpu_culler.h"
#include "sightline/engine/drawing/internal/drawing.h"
#include "sightline/engine/engine.h"
#include "sightline/engine/internal/rebuild.h"
#include "sightline/importers/json/internal/json.h"
#include "sightline/lod/mesh_levels.h"
#include "sightline/render/image/image_metrics.h"

namespace sightline::bench::contribution_bench {
namespace {

using Json = json::Value;
using engine::ContributionMode;

constexpr int kFiner = 8;  // of the reference, along each axis

struct Options {
  apps::ModelOptions model;
  std::uint64_t items = 0;
  int frames = 12, passes = 3;
  double step = 1.0 / 60.0;
  gl::ContextPlatform platform = {};
  std::string size = "640x360", json, plot;
};

void add_options(apps::CommandLine& line, Options& o) {
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
  line.add("--plot", o.plot, "Write plots of error and flicker against time to PREFIX-….svg");
  apps::add_context_option(line, o.platform);
  apps::add_json_option(line, o.json);
  line.examples(
      "  sightline-bench contribution --items 100000 --plot plant --json plant.json\n"
      "  sightline-bench contribution plant.rvm --frames 24 --size 1280x720");
}

// --- rules ---------------------------------------------------------------------------------------------------------

struct Rule {
  enum class Measure { kNone, kSolid, kBox, kOpenSceneGraph, kOpenCascade, kSphere, kLevels };
  Measure measure = Measure::kNone;
  ContributionMode mode = ContributionMode::kDrop;
  double threshold = 0.0;  // pixels, of area or of length
  /// Settings for the engine, which knows only some of the rules: the others are applied before it draws.
  engine::LossConfig losses() const {
    engine::LossConfig losses;
    if (measure == Measure::kSolid) losses.min_projected_area = float(threshold);
    if (measure == Measure::kLevels) losses.lod_error = threshold;
    losses.contribution_mode = mode;
    return losses;
  }
};

std::string name_of(const Rule& rule) {
  switch (rule.measure) {
    case Rule::Measure::kNone:
      return "full";
    case Rule::Measure::kSolid:
      return "solid, " + std::string(engine::name_of(rule.mode));
    case Rule::Measure::kBox:
      return "box";
    case Rule::Measure::kOpenSceneGraph:
      return "osg";
    case Rule::Measure::kOpenCascade:
      return "occt";
    case Rule::Measure::kSphere:
      return "sphere";
    case Rule::Measure::kLevels:
      return "levels";
  }
  return {};
}

/// Rules of one name follow each other, with rising thresholds. `levels`: the scene has meshes that gain by them.
std::vector<Rule> all_rules(bool levels) {
  using Measure = Rule::Measure;
  std::vector<Rule> rules{{}};
  for (const ContributionMode mode :
       {ContributionMode::kDrop, ContributionMode::kPoints, ContributionMode::kStochastic})
    for (const double area : {0.25, 1.0, 4.0, 16.0, 64.0}) rules.push_back({Measure::kSolid, mode, area});
  for (const double area : {0.25, 1.0, 4.0, 16.0, 64.0})
    rules.push_back({Measure::kBox, ContributionMode::kDrop, area});
  for (const Measure measure : {Measure::kOpenSceneGraph, Measure::kOpenCascade})
    for (const double length : {1.0, 2.0, 4.0, 8.0, 16.0}) rules.push_back({measure, ContributionMode::kDrop, length});
  for (const double area : {1.0, 4.0, 16.0, 64.0, 256.0})
    rules.push_back({Measure::kSphere, ContributionMode::kDrop, area});
  if (levels)
    for (const double pixels : {0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0})
      rules.push_back({Measure::kLevels, ContributionMode::kDrop, pixels});
  return rules;
}

/// An item is dropped when the diagonal of its box is below this, times its centre's distance along the view axis.
double least_diagonal(const Rule& rule, const core::View& view, int width, int height) {
  const double w = 0.5 * width, h = 0.5 * height;
  const double fx = w * view.clip_from_eye()[0][0], fy = h * view.clip_from_eye()[1][1];
  switch (rule.measure) {
    case Rule::Measure::kOpenSceneGraph:  // with the viewport's part in that function's scale
      return 2.0 * rule.threshold / std::sqrt(2.0 * (fx * fx + fy * fy + w * w + h * h));
    case Rule::Measure::kOpenCascade:
      return rule.threshold / fy;
    default:
      return 2.0 * std::sqrt(rule.threshold / (std::numbers::pi * fx * fy));
  }
}

/// Replaces `kept` by the items of `in` that the diagonal's rule keeps, and by all lines.
void keep_large(const core::View& view, const core::Snapshot& snapshot, double least, const core::VisibleSet& in,
                core::VisibleSet& kept) {
  const core::ItemBounds& bounds = snapshot.bounds();
  const core::dmat4 rows = glm::transpose(view.eye_from_world());
  const core::vec3 axis(-core::dvec3(rows[2]));
  const auto offset = float(-glm::dot(core::dvec3(rows[2]), bounds.origin) - rows[2].w);
  const auto square = float(least * least);
  kept.clear();
  kept.generation = in.generation;
  const auto visit = [&](core::Slot slot) {
    if (bounds.vacant(slot)) return;
    const core::Aabb box = bounds.box(slot);
    const core::vec3 size = box.max - box.min;
    const float distance = glm::dot(axis, 0.5f * (box.min + box.max)) + offset;
    if (glm::dot(size, size) >= square * distance * distance || snapshot.kind(slot) == core::Kind::kLine)
      kept.single_slots.push_back(slot);
  };
  in.for_each_slot(visit);
  std::sort(kept.single_slots.begin(), kept.single_slots.end());
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

// --- measuring -----------------------------------------------------------------------------------------------------

using ViewPair = std::array<core::View, 2>;

struct Figures {
  Rule rule;
  std::vector<double> flip_mean, flip_p99, wrong_ids, flicker, items, splats, ms, processor_ms;  // of each frame
};

struct Took {
  double ms, processor_ms;
};

class Subject {
 public:
  static core::Expected<std::unique_ptr<Subject>> create(core::Scene& scene, const Options& o, int width, int height) {
    engine::EngineConfig config = drawing_config(width, height, o.platform);
    config.culling.occlusion = engine::OcclusionChoice::kOn;  // without the trials of kAutomatic
    config.losses.lod_error = 1.0;                            // so that levels are built
    auto engine = engine::Engine::create(scene, config);
    if (!engine) return tl::unexpected(engine.error());
    if (auto built = engine->finish_levels(); !built) return tl::unexpected(built.error());
    return std::unique_ptr<Subject>(new Subject(std::move(*engine)));
  }

  /// Whether any mesh has levels.
  bool has_levels() {
    const auto meshes = engine_.drawing()->scene().meshes().meshes();
    return std::ranges::any_of(meshes, [](const auto& mesh) { return lod::needs_levels(*mesh); });
  }

  engine::Engine& engine() { return engine_; }
  const engine::DrawCounts& counts() const { return counts_; }  ///< of the last draw()

  /// Until the image is complete, culling included.
  core::Expected<Took> draw(const Rule& rule, const core::View& view) {
    engine::Drawing& drawing = *engine_.drawing();
    const core::Snapshot& snapshot = engine_.snapshot();
    const render::RenderTarget& target = drawing.target();
    const bool by_engine = rule.measure == Rule::Measure::kNone || rule.measure == Rule::Measure::kSolid ||
                           rule.measure == Rule::Measure::kLevels;
    drawing.set_losses(rule.losses());
    drawing.finish();
    const Took begin{milliseconds(), processor_milliseconds()};
    culler_.cull(view, visible_);
    visible_.generation = snapshot.generation();
    const core::VisibleSet* shown = &visible_;
    if (rule.measure == Rule::Measure::kBox) {
      const core::ItemBounds& bounds = snapshot.bounds();
      culling::ContributionTest(view, bounds.origin, target.width(), target.height())
          .filter(bounds, visible_, float(rule.threshold), large_, {}, lines_);
      shown = &large_;
    } else if (!by_engine) {
      keep_large(view, snapshot, least_diagonal(rule, view, target.width(), target.height()), visible_, large_);
      shown = &large_;
    }
    const engine::Culled culled{view, snapshot, *shown, lines_, &culler_.hierarchy()};
    const auto drawn = drawing.draw({.view = view, .culled = culled, .all = false});
    if (!drawn) return tl::unexpected(drawn.error());
    counts_ = drawn->counts;
    drawing.finish();
    return Took{milliseconds() - begin.ms, processor_milliseconds() - begin.processor_ms};
  }

  /// The same after a frame that does not count, which tells the passes of occlusion what was open.
  core::Expected<Took> draw_again(const Rule& rule, const core::View& view) {
    if (auto ms = draw(rule, view); !ms) return ms;
    return draw(rule, view);
  }

 private:
  explicit Subject(engine::Engine&& engine)
      : engine_(std::move(engine)),
        culler_(engine_.snapshot().bounds()),
        lines_(engine::slots_of_lines(engine_.snapshot())) {}

  engine::Engine engine_;
  culling::CpuCuller culler_;
  core::VisibleSet visible_, large_;
  engine::DrawCounts counts_;
  std::vector<std::uint64_t> lines_;  // a bit per slot
};

core::Expected<std::vector<ViewPair>> views_of(const core::Scene& scene, const Options& o, double aspect) {
  const core::Snapshot snapshot(scene);
  const core::CameraPath path = core::make_tour(snapshot.bounds(), snapshot.bounds().fitted_bounds());
  std::vector<ViewPair> views;
  for (int i = 0; i < o.frames; ++i) {
    const double time = std::min(path.time_of(i, std::max(2, o.frames)), path.end() - o.step);
    auto first = path.view(time, aspect), second = path.view(time + o.step, aspect);
    if (!first || !second) return tl::unexpected((first ? second : first).error());
    views.push_back({std::move(*first), std::move(*second)});
  }
  return views;
}

core::Expected<std::array<image::Image, 2>> draw_reference(Subject& subject, const ViewPair& views) {
  std::array<image::Image, 2> images;
  for (std::size_t i = 0; i < 2; ++i) {
    if (auto ms = subject.draw({}, views[i]); !ms) return tl::unexpected(ms.error());
    auto fine = subject.engine().read_colour();
    if (!fine) return tl::unexpected(fine.error());
    images[i] = reduced(*fine);
  }
  return images;
}

/// Adds the errors of one frame. `full_ids`: of the full image with one sample; that image's own rule sets them.
core::Expected<void> compare(Subject& subject, const ViewPair& views, const std::array<image::Image, 2>& reference,
                             image::IdImage& full_ids, Figures& figures) {
  std::array<image::Image, 2> images;
  image::IdImage ids;
  for (std::size_t i = 0; i < 2; ++i) {
    if (auto ms = subject.draw_again(figures.rule, views[i]); !ms) return tl::unexpected(ms.error());
    auto colour = subject.engine().read_colour();
    if (!colour) return tl::unexpected(colour.error());
    images[i] = std::move(*colour);
    if (i > 0) continue;
    auto read = subject.engine().read_ids();
    if (!read) return tl::unexpected(read.error());
    ids = std::move(*read);
    figures.items.push_back(double(subject.counts().items_drawn));
    figures.splats.push_back(double(subject.counts().splats));
  }
  if (figures.rule.measure == Rule::Measure::kNone) full_ids = ids;
  const auto metrics = image::image_metrics(reference[0], images[0]);
  if (!metrics) return tl::unexpected(metrics.error());
  const auto wrong = image::wrong_ids(full_ids, ids);
  if (!wrong) return tl::unexpected(wrong.error());
  figures.flip_mean.push_back(metrics->flip_mean);
  figures.flip_p99.push_back(metrics->flip_p99);
  figures.wrong_ids.push_back(double(*wrong) / double(ids.ids.size()));
  figures.flicker.push_back(flicker(images, reference));
  return {};
}

/// Times all rules in turns, so that other load of the machine affects all equally. Adds the median of the passes.
core::Expected<void> time_in_turns(Subject& subject, const core::View& view, int passes, std::vector<Figures>& all) {
  std::vector<std::vector<double>> ms(all.size()), processor(all.size());
  for (int pass = 0; pass < passes; ++pass)
    for (std::size_t i = 0; i < all.size(); ++i) {
      const auto took = subject.draw_again(all[i].rule, view);
      if (!took) return tl::unexpected(took.error());
      ms[i].push_back(took->ms);
      processor[i].push_back(took->processor_ms);
    }
  for (std::size_t i = 0; i < all.size(); ++i) {
    all[i].ms.push_back(apps::median(ms[i]));
    all[i].processor_ms.push_back(apps::median(processor[i]));
  }
  return {};
}

core::Expected<std::vector<Figures>> measure(Subject& subject, const std::vector<ViewPair>& views, const Options& o) {
  const auto [width, height] = *apps::parse_size(o.size);
  apps::Progress progress("measuring", 2 * views.size());
  std::size_t step = 0;
  std::vector<std::array<image::Image, 2>> references;
  if (auto done = subject.engine().resize(kFiner * width, kFiner * height); !done) return tl::unexpected(done.error());
  for (const ViewPair& pair : views) {
    auto reference = draw_reference(subject, pair);
    if (!reference) return tl::unexpected(reference.error());
    references.push_back(std::move(*reference));
    progress.advance(++step);
  }
  if (auto done = subject.engine().resize(width, height); !done) return tl::unexpected(done.error());
  std::vector<Figures> all;
  for (const Rule& rule : all_rules(subject.has_levels())) all.push_back({rule, {}, {}, {}, {}, {}, {}, {}, {}});
  for (std::size_t i = 0; i < views.size(); ++i) {
    image::IdImage full_ids;
    for (Figures& figures : all)
      if (auto done = compare(subject, views[i], references[i], full_ids, figures); !done)
        return tl::unexpected(done.error());
    if (auto done = time_in_turns(subject, views[i][0], o.passes, all); !done) return tl::unexpected(done.error());
    progress.advance(++step);
  }
  return all;
}

// --- report --------------------------------------------------------------------------------------------------------

double mean(const std::vector<double>& values) {
  return apps::summarise(values).mean;
}

Json to_json(const Figures& f) {
  return {{"rule", name_of(f.rule)},
          {"threshold", f.rule.threshold},
          {"flip", {{"mean", mean(f.flip_mean)}, {"p99", mean(f.flip_p99)}}},
          {"wrong_ids", mean(f.wrong_ids)},
          {"flicker", mean(f.flicker)},
          {"items", mean(f.items)},
          {"splats", mean(f.splats)},
          {"ms", {{"mean", mean(f.ms)}, {"median", apps::median(f.ms)}, {"frames", f.ms}}},
          {"processor_ms", {{"mean", mean(f.processor_ms)}, {"frames", f.processor_ms}}}};
}

/// A table that is also Markdown.
void print(const std::vector<Figures>& all, std::FILE* out) {
  std::fprintf(out,
               "| rule              | threshold, px | processor ms | ms, mean | first frame | FLIP, mean |    p99 | "
               "wrong ids, %% "
               "| flicker |   items |  splats |\n"
               "| ----------------- | ------------: | -----------: | -------: | ----------: | ---------: | -----: | "
               "-----------: "
               "| ------: | ------: | ------: |\n");
  for (const Figures& f : all)
    std::fprintf(
        out, "| %-17s | %13.4g | %12.1f | %8.1f | %11.1f | %10.5f | %6.4f | %12.2f | %7.3f | %7.0f | %7.0f |\n",
        name_of(f.rule).c_str(), f.rule.threshold, mean(f.processor_ms), mean(f.ms), f.ms.front(), mean(f.flip_mean),
        mean(f.flip_p99), 100.0 * mean(f.wrong_ids), mean(f.flicker), mean(f.items), mean(f.splats));
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
  auto subject = Subject::create(scene, o, width, height);
  if (!subject) return tl::unexpected(subject.error());
  const gl::Context& context = (*subject)->engine().drawing()->context();
  std::FILE* out = apps::table_stream(o.json);
  std::fprintf(out, "%s, %s, %d frames of the tour, %s\n\n", name.c_str(), o.size.c_str(), o.frames,
               renderer_line(context).c_str());
  Json json = renderer_json(context);
  json.update({{"model", name}, {"size", o.size}, {"frames", o.frames}, {"step_s", o.step}, {"passes", o.passes}});
  const auto all = measure(**subject, *views, o);
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
}  // namespace sightline::bench::contribution_bench

sightline::bench::Run sightline::bench::add_contribution(apps::CommandLine& line) {
  using namespace contribution_bench;
  return add_subcommand<Options>(line, add_options, run);
}
