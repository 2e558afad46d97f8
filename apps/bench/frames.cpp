// sightline-bench frames: frames of a tour in several modes, that is with and without tests for items that cannot be
// seen, beside drawing nothing but what is visible in the id image. No test can do better than that without knowing the
// image, so it is the limit to approach.
//
// The items that are visible are read from the id image of the mode "both". All modes take turns in each view, so that
// a machine whose speed changes slows all of them.
#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "sightline/apps/bench/error_time/comparison.h"
#include "sightline/apps/bench/harness.h"
#include "sightline/apps/bench/renderer.h"
#include "sightline/apps/bench/subcommands.h"
#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/need.h"
#include "sightline/apps/common/progress.h"
#include "sightline/apps/common/table.h"
#include "sightline/core/internal/sort_unique.h"
#include "sightline/engine/drawing/internal/drawing.h"
#include "sightline/engine/engine.h"
#include "sightline/engine/internal/engine_parts.h"

namespace sightline::bench::frames_bench {
namespace {

using apps::need;
using engine::Engine;
using Json = json::Value;

struct Options {
  ModelOrPlant model;
  int frames = 100;
  gl::ContextPlatform platform = {};
  std::string size = "640x360", json;
};

void add_options(apps::CommandLine& line, Options& o) {
  add_model_or_plant_options(line, o.model);
  add_frames_option(line, o.frames, 2);
  line.add("--size", o.size, "Pixels").shows_default().accepted_by(apps::parse_size);
  apps::add_context_option(line, o.platform);
  apps::add_json_option(line, o.json);
  line.examples(
      "  sightline-bench frames plant.rvm\n"
      "  sightline-bench frames --items 1000000 --size 1280x720 --frames 200 --json frames.json");
}

struct Mode {
  const char *name, *title;
  bool sample_test = true;
  engine::OcclusionChoice occlusion = engine::OcclusionChoice::kOff;
};
enum : std::size_t { kSamples, kBoth, kLimit };  // in kModes
constexpr Mode kModes[] = {{"samples", "sample test"},
                           {"both", "both tests", true, engine::OcclusionChoice::kOn},
                           {"limit", "the limit", false},
                           {"none", "no test", false}};

constexpr apps::Column kColumns[] = {{"mode", "title"},
                                     {"ms, mean", "ms/mean", "{:.1f}"},
                                     {"median", "ms/median", "{:.1f}"},
                                     {"p99", "ms/p99", "{:.1f}"},
                                     {"processor ms", "processor_ms", "{:.1f}"},
                                     {"items", "items", "{:.0f}"},
                                     {"mean / limit", "mean_ratio", "{:.2f}"},
                                     {"median / limit", "median_ratio", "{:.2f}"}};

struct Flight {
  Engine engine;
  std::vector<double> ms = {}, processor_ms = {}, items = {};  // of each frame; items drawn
};

/// `draw` submits a frame, and returns how many items that are.
template <class Draw>
void fly(Flight& flight, const Draw& draw) {
  const Took begin{milliseconds(), processor_milliseconds()};
  const std::int64_t items = draw(flight.engine);
  flight.engine.finish();
  flight.ms.push_back(milliseconds() - begin.ms);
  flight.processor_ms.push_back(processor_milliseconds() - begin.processor_ms);
  flight.items.push_back(double(items));
}

std::int64_t draw_frame(Engine& engine, const core::View& view) {
  const engine::FrameReport report = need(engine.frame(view));
  if (!report.drawn) apps::fail("the GL context was lost");
  return report.items_drawn;
}

/// Draws the items that are visible in the id image, and nothing else.
std::int64_t draw_visible(Engine& engine, const core::View& view, const core::VisibleSet& visible) {
  engine::Frame frame{view, view, engine.snapshot()};
  frame.all = false;
  need(engine::EngineParts::drawing(engine)->draw(frame, visible));
  return std::int64_t(visible.single_slots.size());
}

core::VisibleSet visible_in(const image::IdImage& ids, const core::Snapshot& snapshot) {
  core::VisibleSet visible;
  visible.generation = snapshot.generation();
  for (const std::uint32_t id : ids.ids)
    if (id != 0) visible.single_slots.push_back(snapshot.slot(core::ItemId{id - 1}));
  core::sort_unique(visible.single_slots);
  return visible;
}

/// Flies all modes; returns the pixels whose item is another in the limit's images.
std::uint64_t fly_all(std::vector<Flight>& flights, const std::vector<core::View>& views) {
  apps::Progress progress("measuring", views.size());
  std::uint64_t different = 0;
  // A first frame compiles programs, and is no part of the flight.
  for (Flight& flight : flights) draw_frame(flight.engine, views[0]);
  for (std::size_t v = 0; v < views.size(); ++v) {
    const core::View& view = views[v];
    for (std::size_t i = 0; i < flights.size(); ++i)
      if (i != kLimit) fly(flights[i], [&](Engine& engine) { return draw_frame(engine, view); });
    const image::IdImage ids = need(flights[kBoth].engine.read_ids());
    const core::VisibleSet visible = visible_in(ids, flights[kLimit].engine.snapshot());
    fly(flights[kLimit], [&](Engine& engine) { return draw_visible(engine, view, visible); });
    different += need(image::wrong_ids(ids, need(flights[kLimit].engine.read_ids())));
    progress.advance(v + 1);
  }
  return different;
}

Json modes_json(const std::vector<Flight>& flights) {
  Json modes;
  const apps::Summary limit = apps::summarise(flights[kLimit].ms);
  for (std::size_t i = 0; i < flights.size(); ++i) {
    const apps::Summary ms = apps::summarise(flights[i].ms);
    modes[kModes[i].name] = {{"title", kModes[i].title},
                             {"ms", apps::to_json(ms)},
                             {"items", apps::summarise(flights[i].items).mean},
                             {"processor_ms", apps::summarise(flights[i].processor_ms).mean},
                             {"mean_ratio", ms.mean / limit.mean},
                             {"median_ratio", ms.median / limit.median}};
  }
  return modes;
}

core::Expected<int> run(const Options& o) {
  const auto [width, height] = need(apps::parse_size(o.size));
  const std::unique_ptr<core::Scene> scene = need(model_or_plant(o.model.model, o.model.items));
  std::vector<Flight> flights;
  for (const Mode& mode : kModes) {
    engine::EngineConfig config = drawing_config(width, height, o.platform);
    config.culling.sample_test = mode.sample_test;
    config.culling.occlusion = mode.occlusion;
    flights.push_back({need(Engine::create(*scene, config))});
  }
  const core::Snapshot& snapshot = flights[0].engine.snapshot();
  const auto views = need(tour_views(snapshot, o.frames, double(width) / height));
  const gl::Context& context = engine::EngineParts::drawing(flights[0].engine)->context();
  std::fprintf(apps::table_stream(o.json), "%s, %s, %d frames of the tour, %s\n\n",
               engine::count_text(snapshot.size()).c_str(), o.size.c_str(), o.frames, renderer_line(context).c_str());
  const std::uint64_t different = fly_all(flights, views);
  Json json = renderer_json(context);
  json.update({{"model", o.model.model.files},
               {"size", o.size},
               {"frames", o.frames},
               {"modes", modes_json(flights)},
               {"other_ids", different}});
  return finish(o.json, json, [](const Json& all, std::FILE* out) {
    apps::print_table(all["modes"], kColumns, out);
    std::fprintf(out, "\npixels whose item is another when visible items are drawn alone: %llu\n",
                 static_cast<unsigned long long>(all["other_ids"].get<std::uint64_t>()));
  });
}

}  // namespace
}  // namespace sightline::bench::frames_bench

sightline::bench::Run sightline::bench::add_frames(apps::CommandLine& line) {
  using namespace frames_bench;
  return add_subcommand<Options>(line, add_options, run);
}
