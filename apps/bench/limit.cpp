// sightline-bench limit: frames of a tour with the tests for what colours no pixel, beside drawing nothing but what
// is visible in the id image. No test can do better than that without knowing the image, so it is the limit to
// approach.
//
// The items that are visible are read from the id image with both tests. All modes take turns in each view, so that a
// machine whose speed changes slows all of them.
#include <algorithm>
#include <cstdio>
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
#include "sightline/engine/drawing/internal/drawing.h"
#include "sightline/engine/engine.h"
#include "sightline/importers/json/internal/json.h"
#include "sightline/render/image/image_metrics.h"

namespace sightline::bench::limit_bench {
namespace {

using Json = json::Value;
using engine::Engine;

struct Options {
  apps::ModelOptions model;
  int frames = 100;
  gl::ContextPlatform platform = {};
  std::string size = "640x360", json;
};

void add_options(apps::CommandLine& line, Options& o) {
  apps::add_model_options(line, o.model);
  add_frames_option(line, o.frames, 2);
  line.add("--size", o.size, "Pixels").shows_default().accepted_by(apps::parse_size);
  apps::add_context_option(line, o.platform);
  apps::add_json_option(line, o.json);
  line.examples(
      "  sightline-bench limit plant.rvm\n"
      "  sightline-bench limit plant.rvm --size 1280x720 --frames 200 --json limit.json");
}

struct Mode {
  const char *name, *title;
  std::vector<double> ms, processor_ms, items;  // of each frame
};

class Bench {
 public:
  Bench(const Options& options, std::vector<core::View> views, std::vector<Engine> engines)
      : options_(options), views_(std::move(views)), engines_(std::move(engines)) {}

  core::Expected<void> run() {
    apps::Progress progress("measuring", views_.size());
    // A first frame compiles programs, and is no part of the flight.
    for (Engine& engine : engines_)
      if (auto made = frame(engine, views_[0]); !made) return tl::unexpected(made.error());
    for (std::size_t i = 0; i < views_.size(); ++i) {
      if (auto done = fly(views_[i]); !done) return tl::unexpected(done.error());
      progress.advance(i + 1);
    }
    return {};
  }
  Json figures() const;

 private:
  /// The ways of drawing, in the order of `engines`. That of the limit has no tests.
  enum : std::size_t { kSamples, kBoth, kLimit };

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
    for (const std::size_t mode : {kSamples, kBoth}) {
      const auto made = frame(engines_[mode], view);
      if (!made) return tl::unexpected(made.error());
      add(mode, *made);
    }
    const auto ids = engines_[kBoth].read_ids();
    if (!ids) return tl::unexpected(ids.error());
    const auto made = draw_visible(view, *ids);
    if (!made) return tl::unexpected(made.error());
    add(kLimit, *made);
    const auto alone = engines_[kLimit].read_ids();
    if (!alone) return tl::unexpected(alone.error());
    const auto wrong = image::wrong_ids(*ids, *alone);
    if (!wrong) return tl::unexpected(wrong.error());
    different_ += *wrong;
    return {};
  }

  /// Draws the items that are visible in the id image, and nothing else.
  core::Expected<Frame> draw_visible(const core::View& view, const image::IdImage& ids) {
    Engine& engine = engines_[kLimit];
    const core::Snapshot& snapshot = engine.snapshot();
    core::VisibleSet visible_in_ids;
    visible_in_ids.generation = snapshot.generation();
    for (const std::uint32_t id : ids.ids)
      if (id != 0) visible_in_ids.single_slots.push_back(snapshot.slot(core::ItemId{id - 1}));
    std::sort(visible_in_ids.single_slots.begin(), visible_in_ids.single_slots.end());
    visible_in_ids.single_slots.erase(
        std::unique(visible_in_ids.single_slots.begin(), visible_in_ids.single_slots.end()),
        visible_in_ids.single_slots.end());
    return timed(engine, [&]() -> core::Expected<std::int64_t> {
      const engine::Culled culled{view, snapshot, visible_in_ids};
      const auto drawn = engine.drawing()->draw({.view = view, .culled = culled, .all = false});
      if (!drawn) return tl::unexpected(drawn.error());
      return std::int64_t(visible_in_ids.single_slots.size());
    });
  }

  void add(std::size_t mode, const Frame& made) {
    modes_[mode].ms.push_back(made.ms);
    modes_[mode].processor_ms.push_back(made.processor_ms);
    modes_[mode].items.push_back(double(made.items));
  }

  const Options& options_;
  std::vector<core::View> views_;
  std::vector<Engine> engines_;
  Mode modes_[3] = {
      {"samples", "sample test", {}, {}, {}}, {"both", "both tests", {}, {}, {}}, {"limit", "the limit", {}, {}, {}}};
  std::uint64_t different_ = 0;  // pixels whose item is another in the limit's images
};

Json Bench::figures() const {
  Json json;
  const apps::Summary limit = apps::summarise(modes_[kLimit].ms);
  for (const Mode& mode : modes_) {
    const apps::Summary ms = apps::summarise(mode.ms);
    json[mode.name] = {{"title", mode.title},
                       {"ms", apps::to_json(ms)},
                       {"items", apps::summarise(mode.items).mean},
                       {"processor_ms", apps::summarise(mode.processor_ms).mean},
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
      "| mode        | ms, mean | median |    p99 | processor ms |   items | mean / limit | median / limit |\n"
      "| ----------- | -------: | -----: | -----: | -----------: | ------: | -----------: | -------------: |\n");
  for (const char* name : {"samples", "both", "limit"}) {
    const Json& mode = json["modes"][name];
    const auto figure = [&](const char* of) { return mode[of].get<double>(); };
    std::fprintf(out, "| %-11s | %8.1f | %6.1f | %6.1f | %12.1f | %7.0f | %12.2f | %14.2f |\n",
                 mode["title"].get<std::string>().c_str(), mode["ms"]["mean"].get<double>(),
                 mode["ms"]["median"].get<double>(), mode["ms"]["p99"].get<double>(), figure("processor_ms"),
                 figure("items"), figure("mean_ratio"), figure("median_ratio"));
  }
  std::fprintf(out, "\npixels whose item is another when visible items are drawn alone: %llu\n",
               static_cast<unsigned long long>(json["modes"]["other_ids"].get<std::uint64_t>()));
}

core::Expected<Engine> make_engine(core::Scene& scene, const Options& o, bool samples, bool occlusion) {
  const auto [width, height] = *apps::parse_size(o.size);
  engine::EngineConfig config = drawing_config(width, height, o.platform);
  config.culling.sample_test = samples;
  config.culling.occlusion = occlusion ? engine::OcclusionChoice::kOn : engine::OcclusionChoice::kOff;
  return Engine::create(scene, config);
}

core::Expected<int> run(const Options& o) {
  auto model = apps::load_model(o.model);
  if (!model) return tl::unexpected(model.error());
  std::vector<Engine> engines;
  for (const auto& [samples, occlusion] : {std::pair(true, false), {true, true}, {false, false}}) {
    auto engine = make_engine(*model->scene, o, samples, occlusion);
    if (!engine) return tl::unexpected(engine.error());
    engines.push_back(std::move(*engine));
  }
  const core::Snapshot& snapshot = engines[0].snapshot();
  const auto [width, height] = *apps::parse_size(o.size);
  auto views = tour_views(snapshot, o.frames, double(width) / height);
  if (!views) return tl::unexpected(views.error());
  const gl::Context& context = engines[0].drawing()->context();
  Json json = renderer_json(context);
  json.update({{"model", o.model.files}, {"size", o.size}, {"frames", o.frames}});
  std::fprintf(apps::table_stream(o.json), "%s, %s, %d frames of the tour, %s\n\n",
               engine::count_text(snapshot.size()).c_str(), o.size.c_str(), o.frames, renderer_line(context).c_str());
  Bench bench(o, std::move(*views), std::move(engines));
  if (auto done = bench.run(); !done) return tl::unexpected(done.error());
  json["modes"] = bench.figures();
  return finish(o.json, json, print);
}

}  // namespace
}  // namespace sightline::bench::limit_bench

sightline::bench::Run sightline::bench::add_limit(apps::CommandLine& line) {
  using namespace limit_bench;
  return add_subcommand<Options>(line, add_options, run);
}
