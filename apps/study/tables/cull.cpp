// sightline-study cull: the culling techniques of apps/study/ on generated platforms and an aircraft, beside production
// and brute force, in one run. Prints the tables of E. T. Carlos, "Frustum Culling Híbrido Utilizando CPU e GPU"
// (2009), chapters 3 and 4, and plots its figures.
#include "sightline/apps/study/tables/cull.h"

#include <algorithm>
#include <cstdio>

#include "sightline/apps/bench/models/aircraft.h"
#include "sightline/apps/bench/models/platforms.h"
#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/output.h"
#include "sightline/apps/common/progress.h"
#include "sightline/apps/study/tables/report.h"
#include "sightline/apps/study/tables/subcommands.h"
#include "sightline/core/camera_path.h"
#include "sightline/core/snapshot.h"
#include "sightline/engine/tour.h"
#include "sightline/importers/plant/plant_generator.h"

namespace sightline::study {
namespace {

// --- models ----------------------------------------------------------------------------------------------------------

Model from_boxes(std::string name, std::vector<core::Aabb> boxes, std::vector<std::uint8_t> kinds, int frames,
                 double seconds) {
  Model model;
  model.name = std::move(name);
  model.boxes = std::move(boxes);
  model.kinds = std::move(kinds);
  core::AabbD bounds;
  std::vector<core::dvec3> centres;
  for (const core::Aabb& b : model.boxes) {
    bounds.grow(core::AabbD{core::dvec3(b.min), core::dvec3(b.max)});
    centres.push_back(0.5 * (core::dvec3(b.min) + core::dvec3(b.max)));
  }
  model.path.seconds = seconds;
  const core::CameraPath flight = engine::make_tour(bounds, centres, seconds);
  const double far = 3.0 * glm::length(bounds.size()) + 10.0;  // behind the scene, so that every test can be used
  for (int i = 0; i < frames; ++i) {
    const core::CameraSample s = flight.sample(flight.time_of(i, frames));
    if (auto view = core::View::perspective(s.pose, s.fovy, 4.0 / 3.0, 0.1, far)) model.path.views.push_back(*view);
  }
  return model;
}

/// Boxes in the order of insertion, relative to the snapshot's origin.
core::Expected<Model> make_platform(const bench::Platform& platform, const CullOptions& options) {
  if (platform.objects() != platform.printed)
    std::fprintf(stderr, "%s: tables 3.1 and 3.2 add up to %llu objects, table 3.2 prints %llu\n", platform.name,
                 static_cast<unsigned long long>(platform.objects()),
                 static_cast<unsigned long long>(platform.printed));
  core::Scene scene;
  importers::PlantOptions config;
  config.items = bench::scaled(platform.objects(), options.scale);
  config.seed = platform.objects();
  if (auto made = importers::generate_plant(config, scene); !made) return tl::unexpected(made.error());
  if (auto done = scene.commit(); !done) return tl::unexpected(done.error());
  const core::Snapshot snapshot(scene);
  std::vector<std::pair<core::ItemId, core::Slot>> items;
  for (core::Slot s = 0; s < snapshot.size(); ++s)
    if (!snapshot.bounds().box(s).empty()) items.emplace_back(snapshot.item(s), s);
  std::sort(items.begin(), items.end());
  std::vector<core::Aabb> boxes;
  std::vector<std::uint8_t> kinds;
  for (const auto& [id, slot] : items) {
    boxes.push_back(snapshot.bounds().box(slot));
    kinds.push_back(bench::mix_of(snapshot.kind(slot)));
  }
  bench::mix_kinds(platform, kinds);
  return from_boxes(platform.name, std::move(boxes), std::move(kinds), options.frames, platform.seconds);
}

core::Expected<int> run(const CullOptions& options) {
  auto models = make_models(options);
  if (!models) return tl::unexpected(models.error());
  std::vector<Results> all;
  json::Value json = json::Value::array();
  for (const Model& model : *models) {
    all.push_back(run_everything(model, session_of(model, options)));
    apps::show_step("");
    json.push_back(to_json(all.back()));
  }
  std::FILE* out = apps::table_stream(options.json);
  options.variants.empty() ? print_tables(all, out) : print_runs(all, out);
  for (const Results& r : all)
    if (!options.plots.empty())
      if (auto w = write_plots(r, options.plots); !w) return tl::unexpected(w.error());
  return bench::finish(options.json, json);
}

}  // namespace

core::Expected<std::vector<Model>> make_models(const CullOptions& options) {
  std::vector<Model> models;
  const auto wanted = [&](const std::string& name) {
    return options.only.empty() || std::find(options.only.begin(), options.only.end(), name) != options.only.end();
  };
  for (const bench::Platform& p : bench::kPlatforms) {
    if (!wanted(p.name)) continue;
    auto model = make_platform(p, options);
    if (!model) return tl::unexpected(model.error());
    models.push_back(std::move(*model));
  }
  if (wanted("aircraft"))
    models.push_back(from_boxes("aircraft", bench::make_aircraft(bench::scaled(bench::kAircraftMeshes, options.scale)),
                                {}, options.frames, bench::kAircraftSeconds));
  if (models.empty()) return core::fail("--only: no such model; there are P-38, P-40, P-43, P-50 and aircraft");
  if (!options.plots.empty())
    if (auto made = apps::make_directory(options.plots); !made) return tl::unexpected(made.error());
  for (Model& model : models) {
    if (model.boxes.empty()) return core::fail(model.name + ": nothing to cull");
    model.prepare(std::size_t(options.samples));
  }
  return models;
}

SessionOptions session_of(const Model& model, const CullOptions& options) {
  return {options.passes, options.variants,
          [&model](const std::string& variant) { apps::show_step(model.name + ": " + variant); }};
}

void add_options(apps::CommandLine& line, CullOptions& options) {
  line.add("--plots", options.plots, "Write the figures into this directory, SVG");
  apps::add_json_option(line, options.json);
  line.add("--frames", options.frames, "Of the path").in_range(2, 100000);
  line.add("--passes", options.passes, "Times the path is flown; medians count").in_range(1, 1000);
  line.add("--samples", options.samples, "Frames that errors are counted on").in_range(1, 100000);
  line.add("--scale", options.scale, "Share of the objects of each model")
      .accepted_by(apps::parse_finite)
      .in_range(1e-3, 10.0);
  line.add("--only", options.only, "These models alone: P-38, P-40, P-43, P-50, aircraft");
  line.add("--variants", options.variants, "These methods alone, by the names that the tables have, and brute force")
      .separated_by(',');
}

bench::Run add_cull(apps::CommandLine& line) {
  line.examples("  sightline-study cull --only P-40 --plots figures --json study.json");
  return bench::add_subcommand<CullOptions>(line, add_options, run);
}

}  // namespace sightline::study
