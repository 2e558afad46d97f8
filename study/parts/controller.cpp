// sightline-study controller: compares the hybrid culler's controller, and that of the dissertation of 2009, with an
// oracle that knows every frame's costs and with the better fixed path, over recorded and generated traces. Needs no
// GL.
#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "sightline/apps/bench/harness.h"
#include "sightline/apps/bench/models/plant_boxes.h"
#include "sightline/apps/bench/synthetic_traces.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/controller_trace.h"
#include "sightline/apps/common/output.h"
#include "sightline/apps/common/svg_plot.h"
#include "sightline/culling/frustum/cpu_culler.h"
#include "sightline/importers/json/internal/json.h"
#include "sightline/study/parts/parts.h"
#include "sightline/study/parts/policy_2009.h"

namespace sightline::bench::controller_bench {
namespace {

using Json = json::Value;

struct Options {
  std::vector<std::string> traces;
  std::string json, plot, record, views;
  std::size_t items = 713'000;
  int seeds = 10;
};

void add_options(apps::CommandLine& line, Options& options) {
  line.add("traces", options.traces, "recorded traces, CSV (sightline-replay --controller-only reads the same)");
  line.add("--plot", options.plot, "chosen / oracle of every trace and policy, SVG");
  line.add("--seeds", options.seeds, "repetitions of each made-up trace with other noise")
      .in_range(1, 1000)
      .shows_default();
  const apps::Option views = line.add("--views", options.views, "with --record: as for sightline-bench cull");
  line.add("--record", options.record, "measure the CPU culler, model the GPU, write a trace and stop").needs(views);
  line.add("--items", options.items, "with --record: boxes of a made-up plant").in_range(1, 50'000'000).shows_default();
  apps::add_json_option(line, options.json);
  line.examples(
      "  sightline-study controller apps/bench/traces/*.csv --plot regret.svg\n"
      "  sightline-study controller --record plant.csv --items 713000 --views views.f64");
}

// --- a trace of the real CPU culler ----------------------------------------------------------------------------------

/// Substitute for a GPU, plausible and no more. Milliseconds.
struct GpuModel {
  double pass = 0.010;           ///< launches, and clusters that are rejected or accepted as a whole
  double per_item = 5e-9;        ///< per item of the scene, for its clusters
  double per_visible = 1e-8;     ///< writing an id
  double draw = 0.2;             ///< rendering on: fixed cost of drawing
  double draw_visible = 2e-6;    ///< cost of drawing a visible item
  double upload_visible = 4e-7;  ///< CPU path: upload of an id
  double noise = 0.05;
};

std::vector<apps::TraceFrame> record(std::span<const core::View> views, std::size_t items) {
  const core::ItemBounds bounds = in_production_order(PlantBoxes(1).make(items));
  const culling::CpuCuller culler(bounds);
  core::VisibleSet set;
  const std::vector<double> times = time_path(views.size(), [&](std::size_t i) { culler.cull(views[i], set); });
  const GpuModel gpu;
  TraceRandom random(1);
  std::vector<apps::TraceFrame> trace;
  for (std::size_t i = 0; i < views.size(); ++i) {
    culler.cull(views[i], set);
    const auto visible = double(set.count());
    const double cull = (gpu.pass + gpu.per_item * double(items) + gpu.per_visible * visible);
    apps::TraceFrame f{};
    f.visible = visible;
    f.cpu_cull_ms = times[i];
    f.gpu_cull_ms = cull * random.around_one(gpu.noise);
    const double draw = (gpu.draw + gpu.draw_visible * visible) * random.around_one(gpu.noise);
    f.cpu_frame_ms = std::max(f.cpu_cull_ms, draw + gpu.upload_visible * visible);  // the two overlap
    f.gpu_frame_ms = draw + f.gpu_cull_ms;                                          // these do not
    trace.push_back(f);
  }
  return trace;
}

// --- figures ---------------------------------------------------------------------------------------------------------

/// Means over the repetitions of one trace.
struct Figures {
  double oracle = 0.0, best_fixed = 0.0, worst_oracle = 0.0, switches = 0.0, probes = 0.0;
  std::size_t frames = 0;

  void add(const apps::TraceResult& r, double weight) {
    oracle += weight * r.chosen_ms / r.oracle_ms;
    best_fixed += weight * r.chosen_ms / r.best_fixed_ms;
    worst_oracle = std::max(worst_oracle, r.chosen_ms / r.oracle_ms);
    switches += weight * double(r.switches);
    probes += weight * double(r.probes);
    frames = r.choice.size();
  }
};

struct Row {
  std::string trace;
  Figures controller, policy_2009;
};

void add(Row& row, const std::vector<apps::TraceFrame>& trace, bool rendering, double weight) {
  row.controller.add(apps::run_controller(trace, rendering), weight);
  row.policy_2009.add(study::run_2009(trace, rendering), weight);
}

/// Whether a path has any costs in the trace. Without a GPU clock there are no cull times.
bool has_costs(const std::vector<apps::TraceFrame>& trace, bool rendering) {
  const auto has = [&](culling::CullPath path) {
    return std::any_of(trace.begin(), trace.end(),
                       [&](const apps::TraceFrame& f) { return culling::is_measured(f.cost(path, rendering)); });
  };
  return has(culling::CullPath::kCpu) && has(culling::CullPath::kGpu);
}

core::Expected<std::vector<Row>> measure(const Options& options) {
  std::vector<Row> rows;
  for (const std::string& file : options.traces) {
    const auto trace = apps::read_controller_trace(file);
    if (!trace) return tl::unexpected(trace.error());
    const std::string name = file.substr(file.find_last_of('/') + 1);
    for (const bool rendering : {false, true}) {
      if (!has_costs(*trace, rendering)) continue;
      rows.push_back({name + (rendering ? ", rendering on" : ", rendering off"), {}, {}});
      add(rows.back(), *trace, rendering, 1.0);
    }
  }
  const std::size_t recorded = rows.size();
  for (int seed = 1; seed <= options.seeds; ++seed) {
    const auto traces = synthetic_traces(std::uint64_t(seed));
    for (std::size_t i = 0; i < traces.size(); ++i) {
      if (seed == 1) rows.push_back({traces[i].name, {}, {}});
      add(rows[recorded + i], traces[i].frames, true, 1.0 / options.seeds);
    }
  }
  return rows;
}

void print(const std::vector<Row>& rows, std::FILE* out) {
  std::fprintf(out, "%-50s | %-37s | %s\n", "", "controller", "2009");
  std::fprintf(out, "%-50s | %7s %7s %7s %6s %6s | %7s %7s %7s %6s %6s\n", "trace", "/oracle", "worst", "/fixed",
               "switch", "probes", "/oracle", "worst", "/fixed", "switch", "probes");
  for (const Row& row : rows) {
    std::fprintf(out, "%-50s", row.trace.c_str());
    for (const Figures* f : {&row.controller, &row.policy_2009})
      std::fprintf(out, " | %7.3f %7.3f %7.3f %6.1f %6.1f", f->oracle, f->worst_oracle, f->best_fixed, f->switches,
                   f->probes);
    std::fprintf(out, "\n");
  }
}

Json to_json(const std::vector<Row>& rows) {
  Json out = Json::array();
  const auto figures = [](const Figures& f) {
    return Json{{"chosen_to_oracle", f.oracle},
                {"worst_chosen_to_oracle", f.worst_oracle},
                {"chosen_to_best_fixed", f.best_fixed},
                {"switches", f.switches},
                {"probes", f.probes}};
  };
  for (const Row& row : rows)
    out.push_back({{"trace", row.trace},
                   {"frames", row.controller.frames},
                   {"controller", figures(row.controller)},
                   {"2009", figures(row.policy_2009)}});
  return Json{{"traces", out}};
}

std::string plot(const std::vector<Row>& rows) {
  std::vector<apps::BarPair> bars;
  for (const Row& row : rows) bars.push_back({row.trace, row.controller.oracle, row.policy_2009.oracle});
  return apps::svg_bars("Cost of the chosen paths / cost of the per-frame oracle", {"controller", "2009"}, bars);
}

core::Expected<int> run(const Options& options) {
  core::Expected<void> done;
  if (!options.record.empty()) {
    const auto views = read_views(options.views);
    if (!views) return tl::unexpected(views.error());
    done = apps::write_text(options.record, apps::controller_trace_csv(record(*views, options.items)));
    if (!done) return tl::unexpected(done.error());
    return apps::kExitOk;
  }
  const auto rows = measure(options);
  if (!rows) return tl::unexpected(rows.error());
  print(*rows, apps::table_stream(options.json));
  done = apps::write_json(options.json, to_json(*rows));
  if (done && !options.plot.empty()) done = apps::write_text(options.plot, plot(*rows));
  if (!done) return tl::unexpected(done.error());
  return apps::kExitOk;
}

}  // namespace
}  // namespace sightline::bench::controller_bench

sightline::bench::Run sightline::bench::add_controller(apps::CommandLine& line) {
  using namespace controller_bench;
  return add_subcommand<Options>(line, add_options, run);
}
