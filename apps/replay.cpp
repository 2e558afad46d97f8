// sightline-replay: flies a camera path through a model, culls and draws every frame, and reports the figures.

#include <cstdio>
#include <filesystem>

#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/controller_trace.h"
#include "sightline/apps/common/flight.h"
#include "sightline/apps/common/frame_words.h"
#include "sightline/apps/common/legend.h"
#include "sightline/apps/common/model.h"
#include "sightline/apps/common/need.h"
#include "sightline/apps/common/output.h"
#include "sightline/apps/common/progress.h"
#include "sightline/apps/common/statistics.h"
#include "sightline/apps/common/style_options.h"
#include "sightline/apps/common/svg_plot.h"
#include "sightline/apps/mpi/session.h"
#include "sightline/core/internal/platform/files.h"
#include "sightline/engine/engine.h"
#include "sightline/engine/tour.h"
#include "sightline/importers/json/internal/json.h"
#include "sightline/importers/view_json.h"
#if SIGHTLINE_HAS_GL
#include "sightline/apps/common/blank.h"
#include "sightline/apps/common/paged_model.h"
#include "sightline/apps/paged_replay.h"
#include "sightline/render/image/image.h"
#endif
#if SIGHTLINE_HAS_GL && SIGHTLINE_HAS_MPI
#include "sightline/apps/mpi/composer.h"
#endif

namespace {

using namespace sightline;
using apps::need;
using Json = json::Value;

struct Options {
  apps::ModelOptions model;
  std::string path, save_path, size = "1280x720", json_file, csv, plot, images, colour_by;
  engine::CullerChoice culler = engine::CullerChoice::kAutomatic;
  std::optional<culling::GpuVariant> gpu_variant;
  int samples = 1;
  apps::DrawnOptions shown;
  int frames = 300, every = 30;
  engine::Renderer renderer = {};
  gl::ContextPlatform platform = {};
  bool no_render = false, mpi = false, settle = false;
  std::string memory, record_both, controller_trace, rendering = "on";
};

void add_controller_options(apps::CommandLine& line, Options& o) {
  const apps::Option trace =
      line.add("--controller-only", o.controller_trace,
               "Run the hybrid's controller over this CSV trace of both paths' costs; no MODEL, no GL")
          .advanced();
  line.option("MODEL").required(false).excludes(trace);
  line.check([&o]() -> core::Expected<void> {
    if (o.model.files.empty() && o.controller_trace.empty()) return core::fail("MODEL is required");
    return {};
  });
  line.add("--rendering", o.rendering, "on: frame times count; off: cull times")
      .one_of({"on", "off"})
      .shows_default()
      .needs(trace)
      .advanced();
}

void add_options(apps::CommandLine& line, Options& o) {
  using apps::OptionGroup;
  apps::CommandLine general = line.group(OptionGroup::kGeneral), engine = line.group(OptionGroup::kEngine);
  apps::add_model_options(line, o.model);
  general.add("--path", o.path, "Camera path JSON file; without it a tour of the model is made").metavar("FILE");
  general.add("--save-path", o.save_path, "Write the path that was flown").metavar("FILE");
  general.add("--frames", o.frames, "Frames, evenly spaced in time").shows_default().in_range(1, 1000000);
  apps::add_culler_option(line, o.culler);
  apps::add_gpu_variant_option(line, o.gpu_variant);
  apps::add_drawn_options(line, o.shown);
  apps::add_samples_option(line, o.samples);
  apps::add_renderer_option(line, o.renderer);
  apps::add_context_option(line, o.platform);
  const apps::Option no_render =
      line.add_flag("--no-render", o.no_render, "Cull only; needs no GL but for the GPU culler");
  general.add("--size", o.size, "Pixels").metavar("WxH").shows_default().accepted_by(apps::parse_size);
  general.add("--json", o.json_file, "Write all figures as JSON to FILE, or - for stdout").metavar("FILE");
  engine.add("--csv,--trace", o.csv, "Write one line per frame: path, state, times, counts").metavar("FILE");
  line.add("--record-both", o.record_both,
           "Fly with the CPU's path, then with the GPU's, and write what each frame cost on either: a trace for "
           "--controller-only")
      .advanced();
  engine.add("--plot", o.plot, "Plot cull time and visible count along the path, SVG")
      .metavar("FILE")
      .accepted_by(apps::parse_svg_name);
  const apps::Option images = general.add("--images", o.images, "Write every N-th frame to this folder (see --every)")
                                  .metavar("FOLDER")
                                  .excludes(no_render);
  general.add("--every", o.every, "With --images: N").shows_default().needs(images).positive();
  apps::add_colour_option(line, o.colour_by).needs(images);
  add_controller_options(line, o);
  const apps::Option mpi =
      line.add_flag("--mpi", o.mpi,
                    "Under mpirun: each process draws a part of the model, and rank 0 gets the images of all")
          .advanced();
  line.mode(mpi, {OptionGroup::kGeneral, OptionGroup::kImport, OptionGroup::kEngine});
#if SIGHTLINE_HAS_GL
  apps::add_memory_option(line, o.memory);
  general.add_flag("--settle", o.settle, "Each frame waits until all of its pages are drawn").needs("--memory");
#endif
}

using apps::Flight, apps::FlownFrame;

core::CameraPath choose_path(const Options& o, const apps::Model& model, const core::Snapshot& snapshot) {
  if (o.path.empty()) {
    const core::FittedBounds fitted = snapshot.bounds().fitted_bounds();
    if (!o.model.quiet) apps::warn_of_outliers(fitted);
    return engine::make_tour(snapshot.bounds(), fitted);  // of the model where --translate put it
  }
  return need(importers::translated(need(importers::read_path(core::platform::path_of(o.path))), model.offset));
}

std::string image_name(int frame) {
  char name[32];
  std::snprintf(name, sizeof name, "frame_%05d.png", frame);
  return name;
}

/// Saves the last frame of the flight.
core::Expected<void> save_image(engine::Engine& engine, const std::string& folder, Flight& flight) {
#if SIGHTLINE_HAS_GL
  const std::string name = image_name(int(flight.frames.size()) - 1);
  const auto image = engine.read_colour();
  if (!image) return tl::unexpected(image.error());
  auto done = image::write_png(*image, core::platform::path_of(folder) / name);
  apps::take_late_reports(engine, flight);
  apps::warn_if_blank(engine, flight.frames.back().report.visible, name);
  return done;
#else
  (void)engine, (void)folder, (void)flight;
  return {};
#endif
}

core::Expected<Flight> fly(const Options& o, engine::Engine& engine, const core::CameraPath& path, double aspect) {
  apps::Progress progress("flying", std::size_t(o.frames));
  const auto after_frame = [&](Flight& flight) -> core::Expected<void> {
    progress.advance(flight.frames.size());
    const bool save = !o.images.empty() && (int(flight.frames.size()) - 1) % o.every == 0;
    return save ? save_image(engine, o.images, flight) : core::Expected<void>();
  };
  return apps::fly(engine, path, {o.frames, aspect, !o.no_render}, after_frame);
}

/// A value of each frame.
struct Row {
  const char* name;  ///< in the table; null: it is not there
  const char* key;   ///< in JSON
  Json (*pick)(const FlownFrame&);
  int decimals = 0;
  bool summarised = true;  ///< in JSON
};
constexpr Row kRows[] = {
    {"cull ms", "cull_ms", [](const FlownFrame& f) { return Json(f.report.cull_ms); }, 4},
    {"GPU cull ms", "gpu_cull_ms", [](const FlownFrame& f) { return Json(f.gpu_cull_ms); }, 4, false},
    {"draw ms", "draw_ms", [](const FlownFrame& f) { return Json(f.report.draw_ms); }, 3},
    {"frame ms", "frame_ms", [](const FlownFrame& f) { return Json(f.report.frame_ms); }, 3},
    {"visible items", "visible", [](const FlownFrame& f) { return Json(f.report.visible); }},
    {"sampled items", "sampled", [](const FlownFrame& f) { return Json(f.report.sampled); }},
    {"drawn items", "items_drawn", [](const FlownFrame& f) { return Json(f.report.items_drawn); }},
    {"mesh triangles", "triangles", [](const FlownFrame& f) { return Json(f.report.triangles); }},
    {"boxes tested", "tested", [](const FlownFrame& f) { return Json(f.report.tested); }},
    {nullptr, "below_min_area", [](const FlownFrame& f) { return Json(f.report.below_min_area); }, 0, false},
    {nullptr, "pending", [](const FlownFrame& f) { return Json(f.report.pending); }, 0, false},
    {nullptr, "splats", [](const FlownFrame& f) { return Json(f.report.splats); }, 0, false},
    {nullptr, "coarseness", [](const FlownFrame& f) { return Json(f.report.coarseness); }, 0, false},
    {nullptr, "earlier", [](const FlownFrame& f) { return Json(f.report.earlier); }, 0, false},
};

/// The measured values of a row: those that are not negative, and frame times from the second frame on, since the first
/// has no predecessor to measure from.
std::vector<double> samples_of(const Flight& flight, const Row& row) {
  std::vector<double> samples;
  for (std::size_t i = std::string_view(row.key) == "frame_ms" ? 1 : 0; i < flight.frames.size(); ++i)
    if (const auto value = row.pick(flight.frames[i]).get<double>(); value >= 0.0) samples.push_back(value);
  return samples;
}

Json to_json(const Options& o, const engine::Engine& engine, const Flight& flight, const std::array<int, 2>& size) {
  Json out = {{"model", o.model.files},
              {"items", engine.snapshot().size()},
              {"renderer", flight.renderer},
              {"culler", name_of(engine.plan().culler)},
              {"size", size},
              {"frames", Json::array()},
              {"summary", {{"switches", flight.switches()}}}};
  for (const engine::PlanEntry& e : engine.plan().entries)
    out["plan"].push_back({{"feature", e.feature}, {"used", e.used}, {"why", e.why}});
  for (const FlownFrame& f : flight.frames) {
    Json frame = {{"t", f.time}, {"path", name_of(f.report.culler)}, {"state", apps::state_name(f.report)}};
    for (const Row& row : kRows) frame[row.key] = row.pick(f);
    out["frames"].push_back(std::move(frame));
  }
  for (const Row& row : kRows)
    if (row.summarised) out["summary"][row.key] = apps::to_json(apps::summarise(samples_of(flight, row)));
  const engine::MemoryReport memory = engine.memory();
  out["memory"] = {{"scene", memory.scene},
                   {"snapshot", memory.snapshot},
                   {"bvh", memory.bvh},
                   {"gpu", memory.gpu},
                   {"levels", memory.levels}};
  return out;
}

std::string to_csv(const Flight& flight) {
  std::string csv = "frame,t,path,state,cull_ms,gpu_cull_ms,draw_ms,frame_ms,visible,tested\n";
  char line[200];
  for (std::size_t i = 0; i < flight.frames.size(); ++i) {
    const FlownFrame& f = flight.frames[i];
    std::snprintf(line, sizeof line, "%zu,%.6f,%s,%s,%.6f,%.6f,%.6f,%.6f,%lld,%lld\n", i, f.time,
                  name_of(f.report.culler).data(), apps::state_name(f.report).data(), f.report.cull_ms, f.gpu_cull_ms,
                  f.report.draw_ms, f.report.frame_ms, (long long)f.report.visible, (long long)f.report.tested);
    csv += line;
  }
  return csv;
}

void print_table(const engine::Engine& engine, const Flight& flight, std::FILE* out) {
  std::fprintf(out, "%zu frames, %zu items, culler %s, renderer %s\n\n", flight.frames.size(), engine.snapshot().size(),
               name_of(engine.plan().culler).data(), flight.renderer.c_str());
  std::fprintf(out, "%-16s %12s %12s %12s %12s\n", "", "mean", "median", "p99", "max");
  for (const Row& row : kRows) {
    const std::vector<double> samples = samples_of(flight, row);
    const std::string_view key = row.key;
    if (!row.name || samples.empty() || (key == "draw_ms" && flight.renderer == "none") ||
        (key == "triangles" && engine.snapshot().of_kind(core::Kind::kMesh).size() == 0))
      continue;
    const apps::Summary s = apps::summarise(samples);
    std::fprintf(out, "%-16s %12.*f %12.*f %12.*f %12.*f\n", row.name, row.decimals, s.mean, row.decimals, s.median,
                 row.decimals, s.p99, row.decimals, s.max);
  }
  if (const culling::Controller* controller = engine.controller())
    std::fprintf(out, "%-16s %12llu  (%llu probes; %zu of %zu frames on the GPU)\n", "switches",
                 (unsigned long long)controller->switches(), (unsigned long long)controller->probes(), flight.on_gpu(),
                 flight.frames.size());
  double cull_ms = 0.0;
  for (const double ms : samples_of(flight, kRows[0])) cull_ms += ms;
  if (cull_ms > 0.0)
    std::fprintf(out, "%-16s %12.3g  (items culled per second of cull time)\n", "items/s",
                 double(engine.snapshot().size() * flight.frames.size()) / (1e-3 * cull_ms));
  const engine::MemoryReport m = engine.memory();
  constexpr double kMiB = 1024.0 * 1024.0;
  std::fprintf(out, "\nmemory MiB: scene %.1f, snapshot %.1f, hierarchy %.1f, GPU %.1f", double(m.scene) / kMiB,
               double(m.snapshot) / kMiB, double(m.bvh) / kMiB, double(m.gpu) / kMiB);
  if (m.levels > 0) std::fprintf(out, ", levels of detail %.1f", double(m.levels) / kMiB);
  std::fprintf(out, "\n");
}

/// Marks where the hybrid had settled on the GPU, and the frames in which it measured the other path.
apps::Marks marks_of(const Flight& flight) {
  apps::Marks marks{"culled on the GPU", {}, "probe of the other path", {}};
  bool on_gpu = false;
  for (std::size_t i = 0; i < flight.frames.size(); ++i) {
    const engine::FrameReport& report = flight.frames[i].report;
    const bool probe = report.state == culling::ControllerState::kProbe, was_on_gpu = on_gpu;
    if (probe)
      marks.ticks.push_back(i);
    else
      on_gpu = report.culler == engine::CullerChoice::kGpu;
    if (on_gpu && !was_on_gpu) marks.bands.push_back({i, i});
    if (on_gpu) marks.bands.back()[1] = i;
  }
  return marks;
}

std::string to_svg(const Options& o, const engine::Engine& engine, const Flight& flight) {
  apps::Series cull{"cull time", "ms", {}}, visible{"visible", "items", {}};
  for (const FlownFrame& f : flight.frames) {
    cull.values.push_back(f.report.cull_ms);
    visible.values.push_back(double(f.report.visible));
  }
  const std::string title = o.model.files.front() + ": " + std::to_string(engine.snapshot().size()) +
                            " items, culler " + std::string(name_of(engine.plan().culler));
  return apps::svg_plot(title, cull, visible, engine.controller() ? marks_of(flight) : apps::Marks{});
}

void write_reports(const Options& o, const engine::Engine& engine, const Flight& flight,
                   const std::array<int, 2>& size) {
  need(apps::write_json(o.json_file, json::sorted(to_json(o, engine, flight, size))));
  if (!o.csv.empty()) need(apps::write_text(o.csv, to_csv(flight)));
  if (!o.plot.empty()) need(apps::write_text(o.plot, to_svg(o, engine, flight)));
}

/// Flies twice, with each path fixed once. A frame's interval is known when the next frame begins, so the last frame
/// has none.
int record_both(const Options& o, const apps::Model& model, engine::EngineConfig config) {
  std::vector<apps::TraceFrame> trace;
  const double not_measured = culling::FrameSample::kNotMeasured;
  for (const auto culler : {engine::CullerChoice::kCpu, engine::CullerChoice::kGpu}) {
    config.culling.culler = culler;
    const bool gpu = culler == engine::CullerChoice::kGpu;
    auto engine = need(engine::Engine::create(*model.scene, config));
    const auto path = choose_path(o, model, engine.snapshot());
    const auto flight = need(fly(o, engine, path, double(config.width) / config.height));
    trace.resize(flight.frames.size(), {not_measured, not_measured, not_measured, not_measured});
    for (std::size_t i = 0; i < trace.size(); ++i) {
      const FlownFrame& frame = flight.frames[i];
      const double interval = i + 1 < trace.size() ? flight.frames[i + 1].report.frame_ms : not_measured;
      const double cull = gpu ? frame.gpu_cull_ms : frame.report.cull_ms;
      (gpu ? trace[i].gpu_cull_ms : trace[i].cpu_cull_ms) = cull > 0.0 ? cull : not_measured;
      (gpu ? trace[i].gpu_frame_ms : trace[i].cpu_frame_ms) = config.draw ? interval : not_measured;
      if (!gpu) trace[i].visible = double(frame.report.visible);
    }
  }
  need(apps::write_text(o.record_both, apps::controller_trace_csv(trace)));
  return apps::kExitOk;
}

/// Runs the hybrid's controller over a recorded trace.
core::Expected<int> replay_controller(const Options& o) {
  const auto trace = need(apps::read_controller_trace(o.controller_trace));
  const apps::TraceResult result = apps::run_controller(trace, o.rendering == "on");
  need(apps::write_json(o.json_file, json::sorted({{"frames", trace.size()},
                                                   {"chosen_ms", result.chosen_ms},
                                                   {"oracle_ms", result.oracle_ms},
                                                   {"best_fixed_ms", result.best_fixed_ms},
                                                   {"switches", result.switches},
                                                   {"probes", result.probes},
                                                   {"choice", result.choice}})));
  std::fprintf(apps::table_stream(o.json_file),
               "%zu frames, rendering %s: chosen %.4f ms, oracle %.4f, best fixed path %.4f; "
               "%llu switches, %llu probes\n",
               trace.size(), o.rendering.c_str(), result.chosen_ms, result.oracle_ms, result.best_fixed_ms,
               (unsigned long long)result.switches, (unsigned long long)result.probes);
  return apps::kExitOk;
}

engine::EngineConfig engine_config(const Options& o) {
  const auto size = need(apps::parse_size(o.size));
  engine::EngineConfig config;
  config.draw = !o.no_render;
  config.drawing.renderer = o.renderer;
  config.drawing.ids = o.mpi;
  config.context.platform = o.platform;
  config.context.gl_state = engine::GlState::kLeave;  // no other context is current here
  config.width = size[0];
  config.height = size[1];
  config.culling.culler = o.culler;
  config.culling.gpu_variant = o.gpu_variant;
  config.drawing.samples = o.samples;
  o.shown.apply(config);
  return config;
}

/// What a flight needs.
struct Flown {
  apps::Model model;
  std::optional<engine::Engine> engine;
  core::CameraPath path;
  std::array<int, 2> size;
};

Flown prepare(const Options& o, const engine::ScenePart& part) {
  auto config = engine_config(o);
  config.culling.part = part;
  if (!o.images.empty()) need(apps::make_directory(o.images));
  auto model = need(apps::load_model(o.model, o.shown));
  auto engine = need(engine::Engine::create(*model.scene, config));
  need(engine.finish_levels());
  apps::note_rays(engine);
  if (o.model.explain) apps::explain(engine.plan());
  const auto colours = need(apps::apply_colours(o.colour_by, *model.scene, engine));
  std::fputs(apps::legend_text(colours).c_str(), apps::table_stream(o.json_file));
  std::optional<core::Snapshot> whole;  // the tour is that of the whole
  if (part.count > 1) whole.emplace(*model.scene);
  auto path = choose_path(o, model, whole ? *whole : engine.snapshot());
  if (!o.save_path.empty()) need(importers::write_path(core::platform::path_of(o.save_path), path));
  return Flown{std::move(model), std::move(engine), std::move(path), {config.width, config.height}};
}

/// One of the processes that draw every frame together. Rank 0 has the images and writes all figures.
core::Expected<int> replay_parts([[maybe_unused]] Options o) {
  const auto session = apps::MpiSession::begin();
  if (!session) return tl::unexpected(session.error());
#if SIGHTLINE_HAS_GL && SIGHTLINE_HAS_MPI
  const bool root = session->rank() == 0;
  if (!root) {
    o.json_file = o.csv = o.plot = o.images = o.save_path = "";
    o.model.quiet = true;
    o.model.explain = false;
  }
  apps::Composer composer(*session);
  auto flown = session->agreed(apps::attempt([&] { return prepare(o, composer.part()); }));
  if (!flown) return tl::unexpected(flown.error());
  const double aspect = double(flown->size[0]) / flown->size[1];
  std::optional<apps::Progress> bar;
  if (root) bar.emplace("flying", std::size_t(o.frames));
  bool agreed = true;
  core::Expected<void> saved;
  const auto after_frame = [&](Flight& flight) -> core::Expected<void> {
    FlownFrame& frame = flight.frames.back();
    const auto view = flown->path.view(frame.time, aspect);
    if (!view) return tl::unexpected(view.error());
    const auto image = composer.read(*flown->engine, *view, frame.report);
    agreed = image.has_value();
    if (!image) return tl::unexpected(image.error());
    frame.report.visible = composer.visible();
    if (bar) bar->advance(flight.frames.size());
    const int number = int(flight.frames.size()) - 1;
    if (saved && !o.images.empty() && number % o.every == 0)
      saved = image::write_png(image->colours, core::platform::path_of(o.images) / image_name(number));
    return {};  // other processes wait for the parts of this one, whatever becomes of its files
  };
  auto flight = apps::fly(*flown->engine, flown->path, {o.frames, aspect, true}, after_frame);
  if (!flight && agreed) session->first_failing(false);  // for which the others wait in read()
  if (!flight) return tl::unexpected(flight.error());
  if (!root) return apps::kExitOk;
  if (!saved) return tl::unexpected(saved.error());
  write_reports(o, *flown->engine, *flight, flown->size);
  std::FILE* out = apps::table_stream(o.json_file);
  std::fprintf(out, "%d processes; figures of rank 0, but for visible items and frame times, which are of all\n",
               session->size());
  print_table(*flown->engine, *flight, out);
#endif
  return apps::kExitOk;
}

core::Expected<int> replay(const Options& o) {
  if (!o.controller_trace.empty()) return replay_controller(o);
  if (o.mpi) return replay_parts(o);
#if SIGHTLINE_HAS_GL
  if (!o.memory.empty())
    return apps::replay_paged({.model = o.model,
                               .memory = o.memory,
                               .path = o.path,
                               .save_path = o.save_path,
                               .size = o.size,
                               .json_file = o.json_file,
                               .images = o.images,
                               .frames = o.frames,
                               .every = o.every,
                               .lod_error = o.shown.lod_error,
                               .budget_ms = o.shown.budget_ms,
                               .settle = o.settle,
                               .platform = o.platform});
#endif
  if (!o.record_both.empty()) {
    return record_both(o, need(apps::load_model(o.model)), engine_config(o));
  }
  auto flown = prepare(o, {});
  const auto flight = need(fly(o, *flown.engine, flown.path, double(flown.size[0]) / flown.size[1]));
  write_reports(o, *flown.engine, flight, flown.size);
  print_table(*flown.engine, flight, apps::table_stream(o.json_file));
  return apps::kExitOk;
}

}  // namespace

int main(int argc, char** argv) {
  apps::CommandLine line(
      "Flies a camera path through a model: culls and draws every frame, and reports times and counts",
      "sightline-replay",
      "  sightline-replay plant.rvm\n"
      "  sightline-replay plant.rvm --frames 500 --no-render --json out.json --plot out.svg\n"
      "  sightline-replay a.rvm b.rvm --path flight.json --images frames --every 10\n"
      "  sightline-replay plant.rvm --culler hybrid --trace out.csv\n"
      "  sightline-replay huge.slc --memory 4G --frames 100 --images frames\n"
      "  mpirun -np 4 sightline-replay plant.rvm --mpi --frames 60 --images frames\n"
      "  sightline-replay plant.rvm --record-both trace.csv\n"
      "  sightline-replay --controller-only trace.csv --rendering off --json -");
  Options options;
  add_options(line, options);
  return line.run(argc, argv, [&] { return replay(options); });
}
