// sightline-bench hybrid: whole frames culled by the CPU, by the GPU and by the hybrid, in turns, on generated
// platforms and an aircraft or on real models. Prints table 6.1 of E. T. Carlos, "Frustum Culling Híbrido Utilizando
// CPU e GPU" (2009), with rendering off and on, and writes the data of its figures 6.1, 6.2 and 6.5 to 6.7.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "sightline/apps/bench/gl_call_count.h"
#include "sightline/apps/bench/harness.h"
#include "sightline/apps/bench/hybrid/report.h"
#include "sightline/apps/bench/hybrid/scenes.h"
#include "sightline/apps/bench/models/aircraft.h"
#include "sightline/apps/bench/renderer.h"
#include "sightline/apps/bench/subcommands.h"
#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/model.h"
#include "sightline/apps/common/need.h"
#include "sightline/apps/common/output.h"
#include "sightline/apps/common/progress.h"
#include "sightline/apps/common/table.h"
#include "sightline/core/snapshot.h"
#include "sightline/importers/plant/plant_generator.h"

namespace sightline::bench::hybrid_bench {
namespace {

using apps::need;
using Json = json::Value;

struct Options {
  apps::ModelOptions model;
  std::vector<std::string> only;
  std::vector<std::uint64_t> submission;
  std::optional<culling::GpuVariant> gpu;
  gl::ContextPlatform platform = {};
  double scale = 1.0;
  int frames = 200, passes = 3, block = 10, warm_up = 10;
  std::string size = "1280x720", rendering = "both", json, csv;
};

void add_options(apps::CommandLine& line, Options& o) {
  apps::add_model_options(line, o.model);
  line.option("MODEL").required(false).described_as("Fly these, each on its own, instead of generated scenes");
  line.add("--only", o.only, "These generated scenes alone: P-38, P-40, P-43, P-50, aircraft")
      .one_of({"P-38", "P-40", "P-43", "P-50", "aircraft"})
      .separated_by(',');
  line.add("--scale", o.scale, "Share of each generated scene's items")
      .accepted_by(apps::parse_finite)
      .in_range(1e-3, 10.0)
      .shows_default();
  line.add("--frames", o.frames, "Frames of a flight").in_range(2, 100'000).shows_default();
  line.add("--passes", o.passes, "Flights of each method; medians count").in_range(1, 1000).shows_default();
  line.add("--block", o.block, "Frames that each method flies in its turn").in_range(1, 100'000).shows_default();
  line.add("--warm-up", o.warm_up, "Frames before each flight that do not count").in_range(1, 10'000).shows_default();
  line.add("--size", o.size, "Pixels").shows_default().accepted_by(apps::parse_size);
  line.add("--rendering", o.rendering, "on: whole frames; off: culling alone; both")
      .one_of({"on", "off", "both"})
      .shows_default();
  apps::add_gpu_variant_option(line, o.gpu);
  line.add("--submission", o.submission,
           "Instead: what frames culled by the GPU cost the CPU, with generated plants of so many items")
      .in_range(1000, 10'000'000)
      .separated_by(',');
  line.add("--csv", o.csv, "Write traces of both paths, and plots of the figures into this directory");
  apps::add_context_option(line, o.platform);
  apps::add_json_option(line, o.json);
  line.examples(
      "  sightline-bench hybrid --scale 0.05 --frames 60 --size 320x180\n"
      "  sightline-bench hybrid --only P-50,aircraft --rendering off --csv figures --json hybrid.json\n"
      "  sightline-bench hybrid a.rvm b.rvm --passes 9\n"
      "  sightline-bench hybrid --submission 10000,100000,1000000");
}

FlightConfig config_of(const Options& o, bool rendering) {
  const std::array<int, 2> size = *apps::parse_size(o.size);
  return {rendering, size[0], size[1], o.warm_up, o.block, o.gpu};
}

/// The automatic tour, as sightline-replay flies it.
std::vector<core::View> tour(core::Scene& scene, const Options& o) {
  need(scene.commit());
  const std::array<int, 2> size = *apps::parse_size(o.size);
  return need(tour_views(core::Snapshot(scene), o.frames, double(size[0]) / size[1]));
}

// --- flights ---------------------------------------------------------------------------------------------------------

struct Bench {
  const Options& options;
  gl::Context& context;
  std::FILE* out;
  Json runs = Json::array();

  void run(const std::string& model, core::Scene& scene, double seconds) {
    const std::vector<core::View> views = tour(scene, options);
    for (const bool rendering : {false, true}) {
      if (options.rendering == (rendering ? "off" : "on")) continue;
      const auto progress = [&](int pass) {
        apps::show_step(model + ", rendering " + (rendering ? "on" : "off") + ": pass " + std::to_string(pass + 1));
      };
      HybridRun run = fly_in_turns(scene, config_of(options, rendering), context, views, options.passes, progress);
      apps::show_step("");
      run.model = model;
      run.seconds = seconds;
      runs.push_back(to_json(run));
      print(runs.back(), out);
      std::fflush(out);
      if (!options.csv.empty()) write_plots(run, options.csv);
    }
  }
};

void run_files(const Options& o, Bench& bench) {
  for (const std::string& file : o.model.files) {
    apps::ModelOptions one = o.model;
    one.files = {file};
    const apps::Model model = need(apps::load_model(one));
    bench.run(std::filesystem::path(file).stem().string(), *model.scene, 60.0);
  }
}

void run_generated(const Options& o, Bench& bench) {
  const auto wanted = [&](const char* name) { return o.only.empty() || std::ranges::count(o.only, name) > 0; };
  for (const Platform& platform : kPlatforms) {
    if (!wanted(platform.name)) continue;
    core::Scene scene;
    need(make_platform_scene(platform, o.scale, scene));
    bench.run(platform.name, scene, platform.seconds);
  }
  if (!wanted("aircraft")) return;
  core::Scene scene;
  make_aircraft_scene(o.scale, scene);
  bench.run("aircraft", scene, kAircraftSeconds);
}

// --- CPU cost of the GPU's path --------------------------------------------------------------------------------------

/// Medians over the frames, and GL calls per frame.
Json measure_submission(const Options& o, gl::Context& context, std::uint64_t items) {
  core::Scene scene;
  need(importers::generate_plant({items, 1}, scene));
  const std::vector<core::View> views = tour(scene, o);
  FlightConfig config = config_of(o, true);
  config.occlusion = engine::OcclusionChoice::kOff;  // one pass: how many there are depends on what hides what
  Pilot pilot(scene, kHybridModes[1], config, context);
  pilot.fly(views, o.warm_up);
  // Counting takes time, so it has separate frames.
  const std::span<const core::View> few(views.data(), std::min<std::size_t>(10, views.size()));
  const double calls = [&] {
    const GlCallCount count(context);
    pilot.fly(few, 0);
    return double(count.calls()) / double(few.size() + 1);
  }();
  const HybridFlight flight = std::move(pilot).land();
  const auto middle = [&](auto HybridFrame::*field) {
    std::vector<double> values;
    for (std::size_t i = 0; i < views.size(); ++i) values.push_back(double(flight.frames[i].*field));
    return apps::median(std::move(values));
  };
  return {{"items", items},
          {"visible", middle(&HybridFrame::visible)},
          {"submit_cull_ms", middle(&HybridFrame::cull_ms)},
          {"thread_ms", middle(&HybridFrame::thread_ms)},
          {"frame_ms", middle(&HybridFrame::frame_ms)},
          {"gl_calls", calls}};
}

Json run_submission(const Options& o, gl::Context& context, std::FILE* out) {
  static constexpr apps::Column kColumns[] = {{"items", "items", "{:.0f}"},
                                              {"visible", "visible", "{:.0f}"},
                                              {"submitting cull, ms", "submit_cull_ms", "{:.4f}"},
                                              {"processor, thread, ms", "thread_ms", "{:.4f}"},
                                              {"frame, ms", "frame_ms", "{:.3f}"},
                                              {"GL calls", "gl_calls", "{:.1f}"}};
  Json rows = Json::array();
  for (const std::uint64_t items : o.submission) rows.push_back(measure_submission(o, context, items));
  std::fprintf(out, "\nFrames culled by the GPU, rendering on, medians\n\n");
  apps::print_table(rows, kColumns, out);
  return rows;
}

core::Expected<int> run(const Options& o) {
  if (!o.csv.empty()) need(apps::make_directory(o.csv));
  gl::Context context = need(gl::Context::create_offscreen({.platform = o.platform}));
  std::FILE* out = apps::table_stream(o.json);
  std::fprintf(out, "%s, %s, %d frames of warm-up, methods in turns of %d frames\n", renderer_line(context).c_str(),
               o.size.c_str(), o.warm_up, o.block);
  Json json = renderer_json(context);
  json.update({{"size", o.size}, {"warm_up", o.warm_up}, {"block", o.block}});
  if (!o.submission.empty()) {
    json["submission"] = run_submission(o, context, out);
  } else {
    Bench bench{o, context, out};
    (o.model.files.empty() ? run_generated : run_files)(o, bench);
    json["runs"] = std::move(bench.runs);
  }
  return finish(o.json, json);
}

}  // namespace
}  // namespace sightline::bench::hybrid_bench

sightline::bench::Run sightline::bench::add_hybrid(apps::CommandLine& line) {
  using namespace hybrid_bench;
  return add_subcommand<Options>(line, add_options, run);
}
