// sightline-study controller: compares the hybrid culler's controller, and that of the dissertation of 2009, with an
// oracle that knows every frame's costs and with the better fixed path, over recorded and generated traces. Needs no
// GL.
#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "sightline/apps/bench/synthetic_traces.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/controller_trace.h"
#include "sightline/apps/common/output.h"
#include "sightline/apps/common/svg_plot.h"
#include "sightline/apps/study/policy_2009.h"
#include "sightline/apps/study/tables/subcommands.h"

namespace sightline::study {
namespace {

using Json = json::Value;

struct ControllerOptions {
  std::vector<std::string> traces;
  std::string json, plot;
  int seeds = 10;
};

void add_options(apps::CommandLine& line, ControllerOptions& options) {
  line.add("traces", options.traces, "recorded traces, CSV (sightline-replay --controller-only reads the same)");
  line.add("--plot", options.plot, "chosen / oracle of every trace and policy, SVG");
  line.add("--seeds", options.seeds, "repetitions of each made-up trace with other noise")
      .in_range(1, 1000)
      .shows_default();
  apps::add_json_option(line, options.json);
  line.examples("  sightline-study controller apps/bench/traces/*.csv --plot regret.svg");
}

/// Means over the repetitions of one trace.
struct Regret {
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

struct TraceRow {
  std::string trace;
  Regret controller, policy_2009;
};

void add(TraceRow& row, const std::vector<apps::TraceFrame>& trace, bool rendering, double weight) {
  row.controller.add(apps::run_controller(trace, rendering), weight);
  row.policy_2009.add(run_2009(trace, rendering), weight);
}

/// Whether a path has any costs in the trace. Without a GPU clock there are no cull times.
bool has_costs(const std::vector<apps::TraceFrame>& trace, bool rendering) {
  const auto has = [&](culling::CullPath path) {
    return std::any_of(trace.begin(), trace.end(),
                       [&](const apps::TraceFrame& f) { return culling::is_measured(f.cost(path, rendering)); });
  };
  return has(culling::CullPath::kCpu) && has(culling::CullPath::kGpu);
}

core::Expected<std::vector<TraceRow>> measure(const ControllerOptions& options) {
  std::vector<TraceRow> rows;
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
    const auto traces = bench::synthetic_traces(std::uint64_t(seed));
    for (std::size_t i = 0; i < traces.size(); ++i) {
      if (seed == 1) rows.push_back({traces[i].name, {}, {}});
      add(rows[recorded + i], traces[i].frames, true, 1.0 / options.seeds);
    }
  }
  return rows;
}

void print(const std::vector<TraceRow>& rows, std::FILE* out) {
  std::fprintf(out, "%-50s | %-37s | %s\n", "", "controller", "2009");
  std::fprintf(out, "%-50s | %7s %7s %7s %6s %6s | %7s %7s %7s %6s %6s\n", "trace", "/oracle", "worst", "/fixed",
               "switch", "probes", "/oracle", "worst", "/fixed", "switch", "probes");
  for (const TraceRow& row : rows) {
    std::fprintf(out, "%-50s", row.trace.c_str());
    for (const Regret* f : {&row.controller, &row.policy_2009})
      std::fprintf(out, " | %7.3f %7.3f %7.3f %6.1f %6.1f", f->oracle, f->worst_oracle, f->best_fixed, f->switches,
                   f->probes);
    std::fprintf(out, "\n");
  }
}

Json to_json(const std::vector<TraceRow>& rows) {
  Json out = Json::array();
  const auto regret = [](const Regret& f) {
    return Json{{"chosen_to_oracle", f.oracle},
                {"worst_chosen_to_oracle", f.worst_oracle},
                {"chosen_to_best_fixed", f.best_fixed},
                {"switches", f.switches},
                {"probes", f.probes}};
  };
  for (const TraceRow& row : rows)
    out.push_back({{"trace", row.trace},
                   {"frames", row.controller.frames},
                   {"controller", regret(row.controller)},
                   {"2009", regret(row.policy_2009)}});
  return Json{{"traces", out}};
}

std::string plot(const std::vector<TraceRow>& rows) {
  std::vector<apps::BarPair> bars;
  for (const TraceRow& row : rows) bars.push_back({row.trace, row.controller.oracle, row.policy_2009.oracle});
  return apps::svg_bars("Cost of the chosen paths / cost of the per-frame oracle", {"controller", "2009"}, bars);
}

core::Expected<int> run_traces(const ControllerOptions& options) {
  const auto rows = measure(options);
  if (!rows) return tl::unexpected(rows.error());
  print(*rows, apps::table_stream(options.json));
  if (!options.plot.empty())
    if (auto done = apps::write_text(options.plot, plot(*rows)); !done) return tl::unexpected(done.error());
  return bench::finish(options.json, to_json(*rows));
}

}  // namespace

bench::Run add_controller(apps::CommandLine& line) {
  return bench::add_subcommand<ControllerOptions>(line, add_options, run_traces);
}

}  // namespace sightline::study
