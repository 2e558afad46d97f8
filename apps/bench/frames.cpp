// sightline-bench frames: frames of a tour in several modes, that is ways of culling and drawing, beside drawing
// nothing but what is visible in the id image. No test can do better than that without knowing the image, so it is the
// limit to approach.
//
// The items that are visible are read from the id image of the mode "both". All modes take turns in each view, so that
// a machine whose speed changes slows all of them.
#include <algorithm>
#include <cstdio>
#include <span>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "sightline/apps/bench/harness.h"
#include "sightline/apps/bench/renderer.h"
#include "sightline/apps/bench/subcommands.h"
#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/model.h"
#include "sightline/apps/common/output.h"
#include "sightline/apps/common/progress.h"
#include "sightline/apps/common/statistics.h"
#include "sightline/core/internal/sort_unique.h"
#include "sightline/engine/drawing/internal/drawing.h"
#include "sightline/engine/engine.h"
#include "sightline/importers/json/internal/json.h"
#include "sightline/render/image/image_metrics.h"

namespace sightline::bench::frames_bench {
namespace {

using Json = json::Value;
using engine::Engine;

struct Options {
  apps::ModelOptions model;
  int frames = 100;
  gl::ContextPlatform platform = {};
  std::string size = "640x360", json;
  std::vector<std::string> also;  // names of kModes
  double budget_ms = 16.0;
};

/// A way of culling and drawing.
struct Mode {
  const char *name, *title;
  bool sample_test = true;
  engine::OcclusionChoice occlusion = engine::OcclusionChoice::kOff;
  engine::CullerChoice culler = engine::CullerChoice::kCpu;
  bool budget = false;
};

/// The first three always fly; their order is that of Bench::kSamples and so on.
constexpr Mode kModes[] = {
    {"samples", "sample test"},
    {"both", "both tests", true, engine::OcclusionChoice::kOn},
    {"limit", "the limit", false},
    {"none", "no test", false},
    {"auto", "occlusion auto", true, engine::OcclusionChoice::kAutomatic},
    {.name = "gpu", .title = "GPU culler", .culler = engine::CullerChoice::kGpu},
    {.name = "hybrid", .title = "hybrid", .culler = engine::CullerChoice::kHybrid},
    {.name = "budget", .title = "budget", .occlusion = engine::OcclusionChoice::kOn, .budget = true},
};
constexpr std::size_t kAlwaysFlown = 3;

std::vector<std::string> names_of_further_modes() {
  std::vector<std::string> names;
  for (const Mode& mode : std::span(kModes).subspan(kAlwaysFlown)) names.emplace_back(mode.name);
  return names;
}

/// Each once, in the order of kModes.
std::vector<const Mode*> flown_modes(const Options& o) {
  std::vector<const Mode*> modes;
  for (const Mode& mode : kModes)
    if (modes.size() < kAlwaysFlown || std::ranges::count(o.also, mode.name) > 0) modes.push_back(&mode);
  return modes;
}

void add_options(apps::CommandLine& line, Options& o) {
  apps::add_model_options(line, o.model);
  add_frames_option(line, o.frames, 2);
  line.add("--size", o.size, "Pixels").shows_default().accepted_by(apps::parse_size);
  line.add(
          "--also", o.also,
          "Further modes beside the sample test, both tests and the limit: without a test, with occlusion auto, culled "
          "by the GPU or the hybrid, with both tests and a budget")
      .separated_by(',')
      .one_of(names_of_further_modes());
  line.add("--budget", o.budget_ms, "Milliseconds a frame of the mode 'budget'").shows_default().positive();
  apps::add_context_option(line, o.platform);
  apps::add_json_option(line, o.json);
  line.examples(
      "  sightline-bench frames plant.rvm\n"
      "  sightline-bench frames plant.rvm --also gpu,hybrid --size 1280x720 --frames 200 --json frames.json");
}

struct Flight {
  const Mode* mode = nullptr;
  Engine engine;
  std::vector<double> ms = {}, processor_ms = {};  // of each frame
  std::vector<double> items = {};                  // drawn; -1 where the GPU culled and does not tell
};

class Bench {
 public:
  Bench(std::vector<core::View> views, std::vector<Flight> flights)
      : views_(std::move(views)), flights_(std::move(flights)) {}

  core::Expected<void> run() {
    apps::Progress progress("measuring", views_.size());
    // A first frame compiles programs, and is no part of the flight.
    for (Flight& flight : flights_)
      if (auto made = frame(flight.engine, views_[0]); !made) return tl::unexpected(made.error());
    for (std::size_t i = 0; i < views_.size(); ++i) {
      if (auto done = fly(views_[i]); !done) return tl::unexpected(done.error());
      progress.advance(i + 1);
    }
    return {};
  }
  Json figures() const;

 private:
  enum : std::size_t { kSamples, kBoth, kLimit };  // in `flights`, as in kModes

  struct Frame {
    double ms = 0.0, processor_ms = 0.0;  // until the image is drawn
    std::int64_t items = 0;
  };

  /// `draw` submits a frame, and returns how many items that are.
  template <class Draw>
  static core::Expected<Frame> timed(Engine& engine, const Draw& draw) {
    const double begin = milliseconds(), processor_begin = processor_milliseconds();
    const core::Expected<std::int64_t> items = draw();
    if (!items) return tl::unexpected(items.error());
    engine.finish();
    return Frame{milliseconds() - begin, processor_milliseconds() - processor_begin, *items};
  }

  static core::Expected<Frame> frame(Engine& engine, const core::View& view) {
    return timed(engine, [&]() -> core::Expected<std::int64_t> {
      const auto report = engine.frame(view);
      if (!report) return tl::unexpected(report.error());
      if (!report->drawn) return core::fail("the GL context was lost");
      return report->items_drawn;
    });
  }

  core::Expected<void> fly(const core::View& view) {
    for (std::size_t i = 0; i < flights_.size(); ++i) {
      if (i == kLimit) continue;
      const auto made = frame(flights_[i].engine, view);
      if (!made) return tl::unexpected(made.error());
      add(flights_[i], *made);
    }
    const auto ids = flights_[kBoth].engine.read_ids();
    if (!ids) return tl::unexpected(ids.error());
    const auto made = draw_visible(view, *ids);
    if (!made) return tl::unexpected(made.error());
    add(flights_[kLimit], *made);
    const auto alone = flights_[kLimit].engine.read_ids();
    if (!alone) return tl::unexpected(alone.error());
    const auto wrong = image::wrong_ids(*ids, *alone);
    if (!wrong) return tl::unexpected(wrong.error());
    different_ += *wrong;
    return {};
  }

  /// Draws the items that are visible in the id image, and nothing else.
  core::Expected<Frame> draw_visible(const core::View& view, const image::IdImage& ids) {
    Engine& engine = flights_[kLimit].engine;
    const core::Snapshot& snapshot = engine.snapshot();
    core::VisibleSet visible_in_ids;
    visible_in_ids.generation = snapshot.generation();
    for (const std::uint32_t id : ids.ids)
      if (id != 0) visible_in_ids.single_slots.push_back(snapshot.slot(core::ItemId{id - 1}));
    core::sort_unique(visible_in_ids.single_slots);
    return timed(engine, [&]() -> core::Expected<std::int64_t> {
      engine::Frame frame{view, view, snapshot};
      frame.all = false;
      const auto drawn = engine.drawing()->draw(frame, visible_in_ids);
      if (!drawn) return tl::unexpected(drawn.error());
      return std::int64_t(visible_in_ids.single_slots.size());
    });
  }

  static void add(Flight& flight, const Frame& made) {
    flight.ms.push_back(made.ms);
    flight.processor_ms.push_back(made.processor_ms);
    flight.items.push_back(double(made.items));
  }

  std::vector<core::View> views_;
  std::vector<Flight> flights_;
  std::uint64_t different_ = 0;  // pixels whose item is another in the limit's images
};

Json Bench::figures() const {
  Json json;
  const apps::Summary limit = apps::summarise(flights_[kLimit].ms);
  for (const Flight& flight : flights_) {
    const apps::Summary ms = apps::summarise(flight.ms);
    json[flight.mode->name] = {
        {"title", flight.mode->title},
        {"ms", apps::to_json(ms)},
        {"items", std::ranges::min(flight.items) < 0.0 ? Json() : Json(apps::summarise(flight.items).mean)},
        {"processor_ms", apps::summarise(flight.processor_ms).mean},
        {"mean_ratio", ms.mean / limit.mean},
        {"median_ratio", ms.median / limit.median}};
  }
  json["other_ids"] = different_;
  return json;
}

/// A table that is also Markdown.
void print(const Json& json, std::FILE* out) {
  std::fprintf(
      out,
      "| mode           | ms, mean | median |    p99 | processor ms |   items | mean / limit | median / limit |\n"
      "| -------------- | -------: | -----: | -----: | -----------: | ------: | -----------: | -------------: |\n");
  for (const Mode& shown : kModes) {
    if (!json["modes"].contains(shown.name)) continue;
    const Json& mode = json["modes"][shown.name];
    const auto figure = [&](const char* of) { return mode[of].get<double>(); };
    const std::string items = mode["items"].is_null() ? "-" : fmt::format("{:.0f}", figure("items"));
    std::fprintf(out, "| %-14s | %8.1f | %6.1f | %6.1f | %12.1f | %7s | %12.2f | %14.2f |\n", shown.title,
                 mode["ms"]["mean"].get<double>(), mode["ms"]["median"].get<double>(), mode["ms"]["p99"].get<double>(),
                 figure("processor_ms"), items.c_str(), figure("mean_ratio"), figure("median_ratio"));
  }
  std::fprintf(out, "\npixels whose item is another when visible items are drawn alone: %llu\n",
               static_cast<unsigned long long>(json["modes"]["other_ids"].get<std::uint64_t>()));
}

core::Expected<Engine> make_engine(core::Scene& scene, const Options& o, const Mode& mode) {
  const auto [width, height] = *apps::parse_size(o.size);
  engine::EngineConfig config = drawing_config(width, height, o.platform);
  config.culling.sample_test = mode.sample_test;
  config.culling.occlusion = mode.occlusion;
  config.culling.culler = mode.culler;
  if (mode.budget) config.losses.budget_ms = o.budget_ms;
  return Engine::create(scene, config);
}

core::Expected<int> run(const Options& o) {
  auto model = apps::load_model(o.model);
  if (!model) return tl::unexpected(model.error());
  std::vector<Flight> flights;
  for (const Mode* mode : flown_modes(o)) {
    auto engine = make_engine(*model->scene, o, *mode);
    if (!engine) return tl::unexpected(engine.error());
    flights.push_back({mode, std::move(*engine)});
  }
  const core::Snapshot& snapshot = flights[0].engine.snapshot();
  const auto [width, height] = *apps::parse_size(o.size);
  auto views = tour_views(snapshot, o.frames, double(width) / height);
  if (!views) return tl::unexpected(views.error());
  const gl::Context& context = flights[0].engine.drawing()->context();
  Json json = renderer_json(context);
  json.update({{"model", o.model.files}, {"size", o.size}, {"frames", o.frames}});
  std::fprintf(apps::table_stream(o.json), "%s, %s, %d frames of the tour, %s\n\n",
               engine::count_text(snapshot.size()).c_str(), o.size.c_str(), o.frames, renderer_line(context).c_str());
  Bench bench(std::move(*views), std::move(flights));
  if (auto done = bench.run(); !done) return tl::unexpected(done.error());
  json["modes"] = bench.figures();
  return finish(o.json, json, print);
}

}  // namespace
}  // namespace sightline::bench::frames_bench

sightline::bench::Run sightline::bench::add_frames(apps::CommandLine& line) {
  using namespace frames_bench;
  return add_subcommand<Options>(line, add_options, run);
}
