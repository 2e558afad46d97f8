// sightline-study budget: what a frame budget leaves of the image while the camera moves, and how long the full
// image takes once it rests: alone, and in turns with the images of other views that rest.
//
// A tour is flown with the budget. Some of its images are compared with the full image of the same view. Beside
// them stands a threshold of contribution in the same time: of several the least whose frame takes no longer than the
// budget. Both drop what is too small, or draw it as splats.
#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "sightline/apps/bench/harness.h"
#include "sightline/apps/bench/renderer.h"
#include "sightline/apps/bench/subcommands.h"
#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/drawn_variant.h"
#include "sightline/apps/common/model.h"
#include "sightline/apps/common/output.h"
#include "sightline/apps/common/progress.h"
#include "sightline/apps/common/setting_options.h"
#include "sightline/apps/common/statistics.h"
#include "sightline/engine/drawing/internal/drawing.h"
#include "sightline/engine/engine.h"
#include "sightline/study/parts/parts.h"

namespace sightline::bench::budget_bench {
namespace {

using Json = json::Value;
using engine::Engine;

constexpr double kWithin = 1.05;      // of the budget
constexpr int kApproach = 4;          // moving frames before a rest
constexpr int kMostAtRest = 100'000;  // frames
constexpr float kThresholds[] = {0.0f, 0.25f, 1.0f, 4.0f, 16.0f, 64.0f, 256.0f, 1024.0f};  // of contribution, pixels

struct Options {
  apps::ModelOptions model;
  double budget_ms = 33.0, lod_error = 0.0;
  int frames = 200, compared = 20, rests = 10, viewports = 4;
  engine::ContributionMode mode = engine::ContributionMode::kDrop;
  gl::ContextPlatform platform = {};
  std::string size = "640x360", json;
};

void add_options(apps::CommandLine& line, Options& o) {
  apps::add_model_options(line, o.model);
  line.add("--budget", o.budget_ms, "Milliseconds for a frame")
      .accepted_by(apps::parse_finite)
      .positive()
      .shows_default();
  add_frames_option(line, o.frames, 2);
  line.add("--compared", o.compared, "Frames whose images are compared, evenly spaced")
      .in_range(1, 10'000)
      .shows_default();
  line.add("--rests", o.rests, "Frames at which the camera comes to rest, evenly spaced")
      .in_range(1, 10'000)
      .shows_default();
  line.add("--viewports", o.viewports, "Views that rest in turns, each with an image of its own, evenly spaced")
      .in_range(1, 100)
      .shows_default();
  line.add_choice("--mode", o.mode, apps::choices_of<engine::ContributionMode, engine::ContributionMode>(),
                  "How what is left out is drawn")
      .shows_default();
  line.add("--lod-error", o.lod_error, "Pixels within which the budget's frames draw meshes by levels of detail")
      .accepted_by(apps::parse_finite)
      .not_negative()
      .shows_default();
  line.add("--size", o.size, "Pixels").shows_default().accepted_by(apps::parse_size);
  apps::add_context_option(line, o.platform);
  apps::add_json_option(line, o.json);
  line.examples(
      "  sightline-study budget plant.rvm\n"
      "  sightline-study budget plant.rvm --mode points\n"
      "  sightline-study budget plant.rvm --budget 16.7 --frames 400 --json budget.json");
}

struct Compared {
  apps::ImageErrors budget, contribution;  // against the full image
  double budget_ms = 0.0, contribution_ms = 0.0, full_ms = 0.0, threshold = 0.0;
};

struct Rest {
  int frames = 0;
  double ms = 0.0;  // of all of them
};

struct Figures {
  std::vector<double> ms, items_drawn;  // of each frame of the tour
  int complete = 0;
  std::vector<Compared> compared;
  std::vector<Rest> rests;
  Rest together;  // of all viewports
};

/// Milliseconds until the image of a view is complete, or its budget spent.
core::Expected<double> timed_frame(Engine& engine, const core::View& view, engine::FrameReport* report = nullptr) {
  const double begin = milliseconds();
  const auto made = engine.frame(view);
  if (!made) return tl::unexpected(made.error());
  if (!made->drawn) return core::fail("the GL context was lost");
  engine.finish();
  if (report) *report = *made;
  return milliseconds() - begin;
}

class Bench {
 public:
  Bench(const Options& options, std::vector<core::View> views, Engine hurried, Engine full)
      : options_(options), views_(std::move(views)), hurried_(std::move(hurried)), full_(std::move(full)) {}

  core::Expected<Figures> run() {
    apps::Progress progress("measuring", views_.size() + std::size_t(options_.rests));
    for (std::size_t i = 0; i < views_.size(); ++i) {
      if (auto done = fly(i); !done) return tl::unexpected(done.error());
      progress.advance(i + 1);
    }
    for (int i = 0; i < options_.rests; ++i) {
      if (auto done = rest(spaced(i, options_.rests)); !done) return tl::unexpected(done.error());
      progress.advance(views_.size() + std::size_t(i) + 1);
    }
    if (auto done = rest_together(); !done) return tl::unexpected(done.error());
    return std::move(figures_);
  }

 private:
  /// The i-th of `count` evenly spaced frames; the first one has neighbours before it.
  std::size_t spaced(int i, int count) const {
    return std::min(views_.size() - 1, std::size_t((i + 0.5) * double(views_.size()) / count));
  }

  core::Expected<void> fly(std::size_t i) {
    engine::FrameReport report;
    const auto ms = timed_frame(hurried_, views_[i], &report);
    if (!ms) return tl::unexpected(ms.error());
    figures_.ms.push_back(*ms);
    figures_.items_drawn.push_back(double(report.items_drawn));
    figures_.complete += report.pending == 0;
    for (int k = 0; k < options_.compared; ++k)
      if (spaced(k, options_.compared) == i) return compare(i, *ms);
    return {};
  }

  core::Expected<void> compare(std::size_t i, double ms) {
    const auto image = apps::read_image(hurried_, views_[i]);
    if (!image) return tl::unexpected(image.error());
    Compared figures;
    figures.budget_ms = ms;
    apps::DrawnImage full;
    for (const float threshold : kThresholds) {
      const auto took = draw_with(threshold, i);
      if (!took) return tl::unexpected(took.error());
      if (threshold == 0.0f) figures.full_ms = *took;
      if (threshold > 0.0f && *took > options_.budget_ms && threshold < std::end(kThresholds)[-1]) continue;
      auto image_of = apps::read_image(full_, views_[i]);
      if (!image_of) return tl::unexpected(image_of.error());
      if (threshold == 0.0f) full = *image_of;
      if (threshold == 0.0f && *took > options_.budget_ms) continue;
      const auto error = apps::image_errors(full, *image_of);
      if (!error) return tl::unexpected(error.error());
      figures.contribution = *error;
      figures.contribution_ms = *took;
      figures.threshold = threshold;
      break;
    }
    const auto error = apps::image_errors(full, *image);
    if (!error) return tl::unexpected(error.error());
    figures.budget = *error;
    figures_.compared.push_back(figures);
    hurried_.paused();
    return {};
  }

  /// Draws the frame before, too, as a flight does.
  core::Expected<double> draw_with(float threshold, std::size_t i) {
    full_.drawing()->set_losses({.min_projected_area = threshold, .contribution_mode = options_.mode});
    if (auto before = timed_frame(full_, views_[i > 0 ? i - 1 : i]); !before) return before;
    return timed_frame(full_, views_[i]);
  }

  core::Expected<void> rest(std::size_t at) {
    for (std::size_t i = at - std::min(at, std::size_t(kApproach)); i < at; ++i)
      if (auto ms = timed_frame(hurried_, views_[i]); !ms) return tl::unexpected(ms.error());
    Rest rest;
    engine::FrameReport report;
    do {
      const auto ms = timed_frame(hurried_, views_[at], &report);
      if (!ms) return tl::unexpected(ms.error());
      rest.ms += *ms;
      if (++rest.frames > kMostAtRest) return core::fail("the image does not become complete");
    } while (report.pending > 0);
    figures_.rests.push_back(rest);
    return {};
  }

  core::Expected<void> rest_together() {
    for (std::int64_t pending = 1; pending > 0;) {
      pending = 0;
      for (int i = 0; i < options_.viewports; ++i) {
        if (auto chosen = hurried_.use_image(std::uint32_t(i + 1)); !chosen) return chosen;
        engine::FrameReport report;
        const auto ms = timed_frame(hurried_, views_[spaced(i, options_.viewports)], &report);
        if (!ms) return tl::unexpected(ms.error());
        figures_.together.ms += *ms;
        pending += report.pending;
        if (++figures_.together.frames > kMostAtRest) return core::fail("the images do not become complete");
      }
    }
    return {};
  }

  const Options& options_;
  std::vector<core::View> views_;
  Engine hurried_, full_;
  Figures figures_;
};

core::Expected<Engine> make_engine(core::Scene& scene, const Options& o, double budget_ms) {
  const auto [width, height] = *apps::parse_size(o.size);
  engine::EngineConfig config = drawing_config(width, height, o.platform);
  config.culling.occlusion = engine::OcclusionChoice::kOn;  // without the trials of kAutomatic
  config.losses.budget_ms = budget_ms;
  config.losses.contribution_mode = o.mode;
  return Engine::create(scene, config);
}

// --- report --------------------------------------------------------------------------------------------------------

template <class Item, class Get>
std::vector<double> all(const std::vector<Item>& items, const Get& get) {
  std::vector<double> values;
  for (const Item& item : items) values.push_back(get(item));
  return values;
}

Json to_json(const std::vector<Compared>& compared, const apps::ImageErrors Compared::*of, const double Compared::*ms) {
  const auto mean = [&](const double apps::ImageErrors::*figure) {
    return apps::summarise(all(compared, [&](const Compared& c) { return c.*of.*figure; })).mean;
  };
  return {{"flip", {{"mean", mean(&apps::ImageErrors::flip_mean)}, {"p99", mean(&apps::ImageErrors::flip_p99)}}},
          {"wrong_ids", mean(&apps::ImageErrors::wrong_share)},
          {"ms", apps::to_json(apps::summarise(all(compared, [&](const Compared& c) { return c.*ms; })))}};
}

Json to_json(const Figures& f, double budget_ms) {
  const auto within = std::count_if(f.ms.begin(), f.ms.end(), [&](double ms) { return ms <= kWithin * budget_ms; });
  Json json;
  json["moving"] = {{"ms", apps::to_json(apps::summarise(f.ms))},
                    {"within", double(within) / double(f.ms.size())},
                    {"complete", double(f.complete) / double(f.ms.size())},
                    {"items_drawn", apps::summarise(f.items_drawn).mean}};
  json["compared"] = {{"budget", to_json(f.compared, &Compared::budget, &Compared::budget_ms)},
                      {"contribution", to_json(f.compared, &Compared::contribution, &Compared::contribution_ms)},
                      {"full_ms", apps::summarise(all(f.compared, [](const Compared& c) { return c.full_ms; })).mean}};
  json["compared"]["contribution"]["thresholds"] = all(f.compared, [](const Compared& c) { return c.threshold; });
  json["compared"]["budget"]["flips"] = all(f.compared, [](const Compared& c) { return c.budget.flip_mean; });
  json["compared"]["contribution"]["flips"] =
      all(f.compared, [](const Compared& c) { return c.contribution.flip_mean; });
  json["rest"] = {{"frames", apps::to_json(apps::summarise(all(f.rests, [](const Rest& r) { return r.frames; })))},
                  {"ms", apps::to_json(apps::summarise(all(f.rests, [](const Rest& r) { return r.ms; })))}};
  json["together"] = {{"frames", f.together.frames}, {"ms", f.together.ms}};
  return json;
}

/// Tables that are also Markdown.
void print(const Json& json, std::FILE* out) {
  const auto figure = [](const Json& from, const char* name) { return from[name].get<double>(); };
  const Json &moving = json["moving"], &compared = json["compared"], &rest = json["rest"];
  std::fprintf(out,
               "| while moving         | ms, mean |    p99 |  within, %% | complete, %% |   items |\n"
               "| -------------------- | -------: | -----: | ---------: | ----------: | ------: |\n"
               "| all frames           | %8.1f | %6.1f | %10.1f | %11.1f | %7.0f |\n\n",
               figure(moving["ms"], "mean"), figure(moving["ms"], "p99"), 100.0 * figure(moving, "within"),
               100.0 * figure(moving, "complete"), figure(moving, "items_drawn"));
  std::fprintf(out,
               "| against full image | ms, mean | FLIP, mean |    p99 | wrong ids, %% |\n"
               "| -------------------- | -------: | ---------: | -----: | -----------: |\n");
  for (const char* mode : {"budget", "contribution"})
    std::fprintf(out, "| %-20s | %8.1f | %10.5f | %6.4f | %12.2f |\n", mode, figure(compared[mode]["ms"], "mean"),
                 figure(compared[mode]["flip"], "mean"), figure(compared[mode]["flip"], "p99"),
                 100.0 * figure(compared[mode], "wrong_ids"));
  std::fprintf(out, "| %-20s | %8.1f | %10s | %6s | %12s |\n\n", "full", figure(compared, "full_ms"), "0", "0", "0");
  std::fprintf(out,
               "| until the image is complete at rest |   mean | median |    max |\n"
               "| ------------------------------------- | -----: | -----: | -----: |\n");
  for (const char* what : {"frames", "ms"})
    std::fprintf(out, "| %-37s | %6.1f | %6.1f | %6.1f |\n", what, figure(rest[what], "mean"),
                 figure(rest[what], "median"), figure(rest[what], "max"));
  std::fprintf(out, "\n%d views that rest in turns are complete after %.0f frames, %.1f ms\n",
               int(json["viewports"].get<double>()), figure(json["together"], "frames"),
               figure(json["together"], "ms"));
}

core::Expected<int> run(const Options& o) {
  auto model = apps::load_model(o.model);
  if (!model) return tl::unexpected(model.error());
  auto hurried = make_engine(*model->scene, o, o.budget_ms);
  if (!hurried) return tl::unexpected(hurried.error());
  engine::EngineConfig coarser = hurried->config();
  coarser.losses.lod_error = o.lod_error;
  if (auto done = hurried->configure(coarser); !done) return tl::unexpected(done.error());
  if (auto done = hurried->finish_levels(); !done) return tl::unexpected(done.error());
  auto full = make_engine(*model->scene, o, 0.0);
  if (!full) return tl::unexpected(full.error());
  const auto [width, height] = *apps::parse_size(o.size);
  auto views = tour_views(full->snapshot(), o.frames, double(width) / height);
  if (!views) return tl::unexpected(views.error());
  const gl::Context& context = full->drawing()->context();
  Json json = renderer_json(context);
  json.update({{"model", o.model.files},
               {"size", o.size},
               {"frames", o.frames},
               {"budget_ms", o.budget_ms},
               {"lod_error", o.lod_error},
               {"viewports", o.viewports},
               {"mode", name_of(o.mode)}});
  std::fprintf(apps::table_stream(o.json), "%s, %s, %.4g ms, %d frames of the tour, %s\n\n",
               engine::count_text(full->snapshot().size()).c_str(), o.size.c_str(), o.budget_ms, o.frames,
               renderer_line(context).c_str());
  const auto figures = Bench(o, std::move(*views), std::move(*hurried), std::move(*full)).run();
  if (!figures) return tl::unexpected(figures.error());
  json.update(to_json(*figures, o.budget_ms));
  return finish(o.json, json, print);
}

}  // namespace
}  // namespace sightline::bench::budget_bench

sightline::bench::Run sightline::bench::add_budget(apps::CommandLine& line) {
  using namespace budget_bench;
  return add_subcommand<Options>(line, add_options, run);
}
