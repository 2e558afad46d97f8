// sightline-study: the culling techniques of study/ on made-up platforms and an aircraft, beside production,
// other libraries and brute force, in one run. Prints the tables of E. T. Carlos, "Frustum Culling Híbrido Utilizando
// CPU e GPU" (2009), chapters 3 and 4, with --gpu 5, and writes the data of its figures. The subcommands rays
// (rays.cpp) and grids (rays_gpu.cpp) are about ray tracing, the others (parts/) about parts of the library.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/model.h"
#include "sightline/apps/common/output.h"
#include "sightline/apps/common/progress.h"
#ifdef SIGHTLINE_STUDY_HAS_GPU
#include "sightline/engine/tour.h"
#include "sightline/study/tables/gpu.h"
#include "sightline/study/tables/rays_gpu.h"
#endif
#include "sightline/apps/bench/models/aircraft.h"
#include "sightline/apps/bench/models/platforms.h"
#include "sightline/core/camera_path.h"
#include "sightline/core/snapshot.h"
#include "sightline/importers/json/internal/json.h"
#include "sightline/importers/plant/plant_generator.h"
#include "sightline/study/parts/parts.h"
#include "sightline/study/session.h"
#include "sightline/study/tables/rays.h"
#include "sightline/study/tables/report.h"

namespace {

using namespace sightline;
using Json = json::Value;

struct Options {
  bool tables = false, gpu = false;
  std::string csv, json;
  int frames = 120, passes = 3, samples = 10;
  double scale = 1.0;
  std::vector<std::string> only, variants;
  bool tour_only = false;
  apps::ModelOptions files;
};

// --- models ----------------------------------------------------------------------------------------------------------

constexpr int kOtherFrames = 60;
constexpr std::size_t kContenders = 6;

/// Far planes lie behind the scene, so that every test can be used.
void add_view(const core::Pose& pose, double fovy, const core::AabbD& bounds, study::Path& path) {
  const double far = 3.0 * glm::length(bounds.size()) + 10.0;
  if (auto view = core::View::perspective(pose, fovy, 4.0 / 3.0, 0.1, far)) path.views.push_back(*view);
}

study::Path tour(const core::CameraPath& flight, const core::AabbD& bounds, int frames, double seconds) {
  study::Path path{"tour", {}, seconds, {}, {}};
  for (int i = 0; i < frames; ++i) {
    const core::CameraSample s = flight.sample(flight.time_of(i, frames));
    add_view(s.pose, s.fovy, bounds, path);
  }
  return path;
}

/// Once around: "orbit" outside and all in view, "turn" on the spot in the middle, "detail" the same with a view of
/// three degrees.
study::Path round(const char* name, double distance, double fovy, const core::AabbD& bounds, int frames) {
  study::Path path{name, {}, 60.0, {}, {}};
  const core::dvec3 centre = 0.5 * (bounds.min + bounds.max);
  for (int i = 0; i < frames; ++i) {
    const double angle = 2.0 * 3.14159265358979 * i / frames;
    const core::dvec3 direction(std::cos(angle), std::sin(angle), 0.2);
    core::Pose pose{centre, centre + direction, {0, 0, 1}};
    if (distance > 0.0) pose = {centre + distance * direction, centre, {0, 0, 1}};
    add_view(pose, fovy, bounds, path);
  }
  return path;
}

study::Model from_boxes(std::string name, std::vector<core::Aabb> boxes, std::vector<std::uint8_t> kinds, int frames,
                        double seconds) {
  study::Model model;
  model.name = std::move(name);
  model.boxes = std::move(boxes);
  model.kinds = std::move(kinds);
  core::AabbD bounds;
  std::vector<core::dvec3> centres;
  for (const core::Aabb& b : model.boxes) {
    bounds.grow(core::AabbD{core::dvec3(b.min), core::dvec3(b.max)});
    centres.push_back(0.5 * (core::dvec3(b.min) + core::dvec3(b.max)));
  }
  model.paths.push_back(tour(engine::make_tour(bounds, centres, seconds), bounds, frames, seconds));
  const int others = std::min(frames, kOtherFrames);
  model.paths.push_back(round("orbit", glm::length(bounds.size()), 0.8, bounds, others));
  model.paths.push_back(round("turn", 0.0, 0.8, bounds, others));
  model.paths.push_back(round("detail", 0.0, 0.05, bounds, others));
  return model;
}

/// `mix`: with its proportions of kinds. Boxes in the order of insertion, relative to the snapshot's origin.
study::Model from_scene(const std::string& name, const core::Scene& scene, int frames, double seconds,
                        const bench::Platform* mix = nullptr) {
  const core::Snapshot snapshot(scene);
  struct Item {
    core::ItemId id;
    core::Slot slot;
  };
  std::vector<Item> items;
  for (core::Slot s = 0; s < snapshot.size(); ++s)
    if (!snapshot.bounds().box(s).empty()) items.push_back({snapshot.item(s), s});
  std::sort(items.begin(), items.end(), [](const Item& a, const Item& b) { return a.id < b.id; });
  std::vector<core::Aabb> boxes;
  std::vector<std::uint8_t> kinds;
  for (const Item& item : items) {
    boxes.push_back(snapshot.bounds().box(item.slot));
    kinds.push_back(bench::mix_of(snapshot.kind(item.slot)));
  }
  if (mix != nullptr) bench::mix_kinds(*mix, kinds);
  return from_boxes(name, std::move(boxes), std::move(kinds), frames, seconds);
}

core::Expected<study::Model> make_platform(const bench::Platform& platform, const Options& options) {
  core::Scene scene;
  importers::PlantOptions config;
  config.items = bench::scaled(platform.objects(), options.scale);
  config.seed = platform.objects();
  if (auto made = importers::generate_plant(config, scene); !made) return tl::unexpected(made.error());
  if (auto done = scene.commit(); !done) return tl::unexpected(done.error());
  return from_scene(platform.name, scene, options.frames, platform.seconds, &platform);
}

// --- the tool --------------------------------------------------------------------------------------------------------

core::Expected<std::vector<study::Model>> make_models(const Options& options) {
  std::vector<study::Model> models;
  const auto wanted = [&](const std::string& name) {
    return options.only.empty() || std::find(options.only.begin(), options.only.end(), name) != options.only.end();
  };
  for (const bench::Platform& p : bench::kPlatforms) {
    if (!wanted(p.name)) continue;
    if (p.objects() != p.printed)
      std::fprintf(stderr, "%s: tables 3.1 and 3.2 add up to %llu objects, table 3.2 prints %llu\n", p.name,
                   static_cast<unsigned long long>(p.objects()), static_cast<unsigned long long>(p.printed));
    auto model = make_platform(p, options);
    if (!model) return tl::unexpected(model.error());
    models.push_back(std::move(*model));
  }
  for (const std::string& file : options.files.files) {
    apps::ModelOptions one = options.files;
    one.files = {file};
    auto loaded = apps::load_model(one);
    if (!loaded) return tl::unexpected(loaded.error());
    models.push_back(from_scene(std::filesystem::path(file).stem().string(), *loaded->scene, options.frames, 60.0));
  }
  if (wanted("aircraft"))
    models.push_back(from_boxes("aircraft", bench::make_aircraft(bench::scaled(bench::kAircraftMeshes, options.scale)),
                                {}, options.frames, bench::kAircraftSeconds));
  if (models.empty()) return core::fail("--only: no such model; there are P-38, P-40, P-43, P-50 and aircraft");
  return models;
}

study::SessionOptions session_of(const study::Model& model, const Options& options) {
  return {options.passes, options.variants,
          [&model](const std::string& variant) { apps::show_step(model.name + ": " + variant); }};
}

study::ModelResults run_model(const study::Model& model, const Options& options) {
  const study::SessionOptions session = session_of(model, options);
  study::ModelResults results{study::run_everything(model, session)};
  for (std::size_t i = 1; i < model.paths.size() && !options.tour_only; ++i)
    results.push_back(study::run_contenders(results.front(), model.paths[i], kContenders, session));
  apps::show_step("");
  return results;
}

/// Makes and prepares the models, and gives each to `run`.
template <class RunModel>
core::Expected<void> for_each_model(std::vector<study::Model>& models, const Options& options, const RunModel& run) {
  auto made = make_models(options);
  if (!made) return tl::unexpected(made.error());
  models = std::move(*made);
  for (study::Model& model : models) {
    if (model.boxes.empty()) return core::fail(model.name + ": nothing to cull");
    model.prepare(std::size_t(options.samples));
    if (core::Expected<void> done = run(model); !done) return done;
  }
  return {};
}

/// Writes `all` and `json` where the options want them.
template <class ResultsOfModel, class Print, class WriteFigures>
core::Expected<int> report(const Options& options, const std::vector<ResultsOfModel>& all, const Json& json,
                           const Print& print, const WriteFigures& write_figures) {
  if (options.tables && options.json != "-") print(all);
  if (!options.csv.empty()) {
    if (auto made = apps::make_directory(options.csv); !made) return tl::unexpected(made.error());
    for (const ResultsOfModel& r : all)
      if (auto w = write_figures(r, options.csv); !w) return tl::unexpected(w.error());
  }
  if (auto w = apps::write_json(options.json, json); !w) return tl::unexpected(w.error());
  return apps::kExitOk;
}

core::Expected<int> run_study(const Options& options) {
  std::vector<study::Model> models;
  std::vector<study::ModelResults> all;
  Json json = Json::array();
  auto done = for_each_model(models, options, [&](const study::Model& model) -> core::Expected<void> {
    all.push_back(run_model(model, options));
    for (const study::Results& r : all.back()) json.push_back(study::to_json(r));
    return {};
  });
  if (!done) return tl::unexpected(done.error());
  return report(options, all, json, options.variants.empty() ? study::print_tables : study::print_runs,
                study::write_figures);
}

#ifdef SIGHTLINE_STUDY_HAS_GPU
core::Expected<int> run_gpu_study(const Options& options) {
  auto context = gl::Context::create_offscreen();
  if (!context) return tl::unexpected(context.error());
  std::vector<study::Model> models;
  std::vector<study::GpuResults> all;
  Json json = Json::array();
  auto done = for_each_model(models, options, [&](const study::Model& model) -> core::Expected<void> {
    auto results = study::run_gpu(*context, model, session_of(model, options));
    apps::show_step("");
    if (!results) return tl::unexpected(results.error());
    json.push_back(study::to_json(results->culling));
    if (results->drawing) json.push_back(study::to_json(*results->drawing));
    all.push_back(std::move(*results));
    return {};
  });
  if (!done) return tl::unexpected(done.error());
  const auto print = [&](const std::vector<study::GpuResults>& r) { study::print_gpu(*context, r); };
  return report(options, all, json, print, study::write_gpu_figures);
}
#endif

void add_options(apps::CommandLine& line, Options& options) {
  line.add_flag("--tables", options.tables, "print the tables (not with --json -)");
  line.add("--csv", options.csv, "write figures' data, Pareto data and plots into this directory");
  apps::add_json_option(line, options.json);
  line.add("--frames", options.frames, "frames per path").in_range(2, 100000);
  line.add("--passes", options.passes, "times each path is flown; medians count").in_range(1, 1000);
  line.add("--samples", options.samples, "frames that errors are counted on").in_range(1, 100000);
  line.add("--scale", options.scale, "share of the objects of each model")
      .accepted_by(apps::parse_finite)
      .in_range(1e-3, 10.0);
  line.add("--only", options.only, "these models alone: P-38, P-40, P-43, P-50, aircraft");
  line.add("--variants", options.variants, "these methods alone, by the names that the tables have, and brute force")
      .separated_by(',');
  line.add_flag("--tour-only", options.tour_only, "leave out the paths that only the fastest methods fly");
  line.add("--model", options.files.files, "real models besides (RVM, OBJ), each on its own");
#ifdef SIGHTLINE_STUDY_HAS_GPU
  line.add_flag("--gpu", options.gpu, "the GPU techniques instead: figures 5.14 and 5.15");
#endif
}

}  // namespace

int main(int argc, char** argv) {
  apps::CommandLine line("Frustum culling techniques of 2009 and before, beside production: error against time.",
                         "sightline-study",
                         "  sightline-study --tables --scale 0.05 --frames 30\n"
                         "  sightline-study --tables --only P-40 --csv figures --json study.json\n"
                         "  sightline-study rays --tables --scan 100000");
  Options options;
  add_options(line, options);
  apps::CommandLine rays = line.subcommand("rays", "structures and traversals of ray tracing instead");
  const auto run_rays = study::add_rays(rays);
#ifdef SIGHTLINE_STUDY_HAS_GPU
  apps::CommandLine grids = line.subcommand("grids", "uniform grids of all sizes on CPU and GPU instead");
  const auto run_grids = study::add_grids(grids);
#endif
  std::vector<std::pair<apps::CommandLine, bench::Run>> parts;
  for (const auto& [name, description, add] : bench::parts()) {
    apps::CommandLine part = line.subcommand(name, description);
    parts.emplace_back(part, add(part));
  }
  return line.run(argc, argv, [&] {
    for (const auto& [part, run] : parts)
      if (part.chosen()) return run();
    if (rays.chosen()) return run_rays();
#ifdef SIGHTLINE_STUDY_HAS_GPU
    if (grids.chosen()) return run_grids();
    if (options.gpu) return run_gpu_study(options);
#endif
    return run_study(options);
  });
}
