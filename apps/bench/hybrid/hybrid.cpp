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
#include "sightline/apps/common/output.h"
#include "sightline/apps/common/progress.h"
#include "sightline/apps/common/statistics.h"
#include "sightline/core/snapshot.h"
#include "sightline/importers/plant/plant_generator.h"

namespace sightline::bench::hybrid_bench {
namespace {

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
  line.add("--csv", o.csv, "Write frames, traces of both paths, and plots of the figures into this directory");
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
core::Expected<std::vector<core::View>> tour(core::Scene& scene, const Options& o) {
  if (auto done = scene.commit(); !done) return tl::unexpected(done.error());
  const std::array<int, 2> size = *apps::parse_size(o.size);
  return tour_views(core::Snapshot(scene), o.frames, double(size[0]) / size[1]);
}

void print_machine(const Options& o, const gl::Context& context, std::FILE* out) {
  std::fprintf(out, "%s, %s, %d frames of warm-up, methods in turns of %d frames\n", renderer_line(context).c_str(),
               o.size.c_str(), o.warm_up, o.block);
}

Json machine_json(const Options& o, const gl::Context& context) {
  Json json = renderer_json(context);
  json.update({{"size", o.size}, {"warm_up", o.warm_up}, {"block", o.block}});
  return json;
}

// --- flights ---------------------------------------------------------------------------------------------------------

class Bench {
 public:
  Bench(const Options& options, gl::Context& context)
      : options_(options), context_(context), out_(apps::table_stream(options.json)) {
    print_machine(options_, context_, out_);
    json_ = machine_json(options_, context_);
  }

  core::Expected<void> run(const std::string& model, core::Scene& scene, double seconds) {
    const auto views = tour(scene, options_);
    if (!views) return tl::unexpected(views.error());
    for (const bool rendering : {false, true}) {
      if (options_.rendering == (rendering ? "off" : "on")) continue;
      auto run = fly_in_turns(scene, config_of(options_, rendering), context_, *views, options_.passes, [&](int pass) {
        apps::show_step(model + ", rendering " + (rendering ? "on" : "off") + ": pass " + std::to_string(pass + 1));
      });
      apps::show_step("");
      if (!run) return tl::unexpected(run.error());
      run->model = model;
      run->seconds = seconds;
      print(*run, out_);
      std::fflush(out_);
      json_["runs"].push_back(to_json(*run));
      if (options_.csv.empty()) continue;
      if (auto done = write_figures(*run, options_.csv); !done) return done;
    }
    return {};
  }
  Json json() && { return std::move(json_); }

 private:
  const Options& options_;
  gl::Context& context_;
  std::FILE* out_;
  Json json_;
};

core::Expected<void> run_files(const Options& o, Bench& bench) {
  for (const std::string& file : o.model.files) {
    apps::ModelOptions one = o.model;
    one.files = {file};
    auto model = apps::load_model(one);
    if (!model) return tl::unexpected(model.error());
    if (auto done = bench.run(std::filesystem::path(file).stem().string(), *model->scene, 60.0); !done) return done;
  }
  return {};
}

core::Expected<void> run_generated(const Options& o, Bench& bench) {
  const auto wanted = [&](const std::string& name) {
    return o.only.empty() || std::find(o.only.begin(), o.only.end(), name) != o.only.end();
  };
  for (const Platform& platform : kPlatforms) {
    if (!wanted(platform.name)) continue;
    core::Scene scene;
    auto done = make_platform_scene(platform, o.scale, scene);
    if (done) done = bench.run(platform.name, scene, platform.seconds);
    if (!done) return done;
  }
  if (!wanted("aircraft")) return {};
  core::Scene scene;
  make_aircraft_scene(o.scale, scene);
  return bench.run("aircraft", scene, kAircraftSeconds);
}

// --- CPU cost of the GPU's path --------------------------------------------------------------------------------------

struct Submission {
  std::uint64_t items = 0;
  double visible = 0.0, cull_ms = 0.0, thread_ms = 0.0, frame_ms = 0.0;  // medians over the frames
  double calls = 0.0;                                                    // GL calls per frame
};

core::Expected<Submission> measure_submission(const Options& o, gl::Context& context, std::uint64_t items) {
  core::Scene scene;
  if (auto made = importers::generate_plant({items, 1}, scene); !made) return tl::unexpected(made.error());
  const auto views = tour(scene, o);
  if (!views) return tl::unexpected(views.error());
  FlightConfig config = config_of(o, true);
  config.occlusion = engine::OcclusionChoice::kOff;  // one pass: how many there are depends on what hides what
  auto pilot = Pilot::create(scene, kHybridModes[1], config, context);
  if (!pilot) return tl::unexpected(pilot.error());
  auto done = pilot->fly(*views, o.warm_up);
  double calls = 0.0;
  if (done) {  // counting takes time, so it has separate frames
    const std::span<const core::View> few(views->data(), std::min<std::size_t>(10, views->size()));
    const GlCallCount count(context);
    done = pilot->fly(few, 0);
    calls = double(count.calls()) / double(few.size() + 1);
  }
  if (!done) return tl::unexpected(done.error());
  const HybridFlight flight = std::move(*pilot).land();
  const auto middle = [&](const auto& pick) {
    std::vector<double> values;
    for (std::size_t i = 0; i < views->size(); ++i) values.push_back(double(pick(flight.frames[i])));
    return apps::median(std::move(values));
  };
  return Submission{items,
                    middle([](const HybridFrame& f) { return f.visible; }),
                    middle([](const HybridFrame& f) { return f.cull_ms; }),
                    middle([](const HybridFrame& f) { return f.thread_ms; }),
                    middle([](const HybridFrame& f) { return f.frame_ms; }),
                    calls};
}

core::Expected<Json> run_submission(const Options& o, gl::Context& context) {
  std::FILE* out = apps::table_stream(o.json);
  print_machine(o, context, out);
  std::fprintf(out, "\nFrames culled by the GPU, rendering on, medians\n%10s %10s %16s %18s %10s %10s\n", "items",
               "visible", "submitting cull", "processor, thread", "frame", "GL calls");
  Json json = machine_json(o, context);
  for (const std::uint64_t items : o.submission) {
    const auto s = measure_submission(o, context, items);
    if (!s) return tl::unexpected(s.error());
    std::fprintf(out, "%10llu %10.0f %13.4f ms %15.4f ms %7.3f ms %10.1f\n", (unsigned long long)items, s->visible,
                 s->cull_ms, s->thread_ms, s->frame_ms, s->calls);
    std::fflush(out);
    json["submission"].push_back({{"items", items},
                                  {"visible", s->visible},
                                  {"submit_cull_ms", s->cull_ms},
                                  {"thread_ms", s->thread_ms},
                                  {"frame_ms", s->frame_ms},
                                  {"gl_calls", s->calls}});
  }
  return json;
}

core::Expected<int> run(const Options& o) {
  if (!o.csv.empty())
    if (auto made = apps::make_directory(o.csv); !made) return tl::unexpected(made.error());
  auto context = gl::Context::create_offscreen({.platform = o.platform});
  if (!context) return tl::unexpected(context.error());
  Json json;
  if (!o.submission.empty()) {
    auto made = run_submission(o, *context);
    if (!made) return tl::unexpected(made.error());
    json = std::move(*made);
  } else {
    Bench bench(o, *context);
    auto done = o.model.files.empty() ? run_generated(o, bench) : run_files(o, bench);
    if (!done) return tl::unexpected(done.error());
    json = std::move(bench).json();
  }
  return finish(o.json, json);
}

}  // namespace
}  // namespace sightline::bench::hybrid_bench

sightline::bench::Run sightline::bench::add_hybrid(apps::CommandLine& line) {
  using namespace hybrid_bench;
  return add_subcommand<Options>(line, add_options, run);
}
