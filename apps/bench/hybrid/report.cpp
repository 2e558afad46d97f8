#include "sightline/apps/bench/hybrid/report.h"

#include <algorithm>

#include "sightline/apps/bench/harness.h"
#include "sightline/apps/common/controller_trace.h"
#include "sightline/apps/common/need.h"
#include "sightline/apps/common/output.h"
#include "sightline/apps/common/svg_plot.h"
#include "sightline/apps/common/table.h"

namespace sightline::bench {
namespace {

template <class Pick>
double mean_over_passes(const std::vector<HybridFlight>& flights, const Pick& pick) {
  double sum = 0.0;
  for (const HybridFlight& flight : flights) sum += pick(flight);
  return sum / double(flights.size());
}

double share_on_gpu(const HybridFlight& flight) {
  const auto on =
      std::count_if(flight.frames.begin(), flight.frames.end(), [](const HybridFrame& f) { return f.on_gpu; });
  return double(on) / double(flight.frames.size());
}

/// Mean over the frames whose count arrived.
double mean_visible(const HybridFlight& flight) {
  double sum = 0.0, known = 0.0;
  for (const HybridFrame& f : flight.frames)
    if (f.visible >= 0) sum += double(f.visible), known += 1.0;
  return known > 0.0 ? sum / known : -1.0;
}

const char* how_off_is_timed(const HybridRun& run) {
  for (const HybridFrame& f : run.flights[1].front().frames)
    if (f.gpu_cull_ms >= 0.0) return "the GPU's clock";
  return "whole frames of culling alone (no GPU clock)";
}

std::string file_name(const HybridRun& run) {
  std::string name = run.model + (run.rendering ? "_on" : "_off");
  std::replace(name.begin(), name.end(), '/', '_');
  return name;
}

/// The cost of both paths in each frame of a pass. With rendering off there are no frame times, but there are cull
/// times even without a GPU clock.
std::string controller_trace(const HybridRun& run, std::size_t pass) {
  const auto measured = [](double ms) { return ms > 0.0 ? ms : culling::FrameSample::kNotMeasured; };
  std::vector<apps::TraceFrame> trace;
  for (std::size_t i = 0; i < run.frames(); ++i) {
    const HybridFrame& cpu = run.flights[0][pass].frames[i];
    const HybridFrame& gpu = run.flights[1][pass].frames[i];
    apps::TraceFrame frame{};
    frame.cpu_cull_ms = measured(cpu.cull_ms);
    frame.gpu_cull_ms = measured(run.rendering ? gpu.gpu_cull_ms : gpu.cost(false));
    frame.cpu_frame_ms = measured(run.rendering ? cpu.frame_ms : -1.0);
    frame.gpu_frame_ms = measured(run.rendering ? gpu.frame_ms : -1.0);
    frame.visible = double(cpu.visible);
    trace.push_back(frame);
  }
  return apps::controller_trace_csv(trace);
}

std::string figure_svg(const HybridRun& run, const char* figure, std::initializer_list<std::size_t> modes) {
  apps::Panel panel;
  for (const std::size_t mode : modes) {
    using Style = apps::PanelSeries::Style;
    apps::PanelSeries line{kHybridModes[mode].name, {}, mode == 2 ? Style::kHeavyLine : Style::kLine};
    const std::vector<double> costs = run.costs(mode);
    for (std::size_t i = 0; i < costs.size(); ++i)
      if (costs[i] > 0.0) line.points.push_back({double(i), 1e3 / costs[i], {}});
    panel.series.push_back(std::move(line));
  }
  return apps::svg_panels(
      {.title = std::string("Figure ") + figure + ", " + run.model + ", rendering " + (run.rendering ? "on" : "off"),
       .x_label = "frame",
       .y_label = "frames per second",
       .panels = {std::move(panel)},
       .log_x = false,
       .large = true});
}

}  // namespace

json::Value to_json(const HybridRun& run) {
  json::Value out = {{"model", run.model},
                     {"items", run.items},
                     {"rendering", run.rendering ? "on" : "off"},
                     {"gpu_variant", run.flights[1].front().gpu_variant},
                     {"frames", run.frames()},
                     {"passes", run.flights[0].size()},
                     {"better_path", kHybridModes[run.better_path()].name}};
  if (!run.rendering) out["gpu_culling_timed_by"] = how_off_is_timed(run);
  for (std::size_t m = 0; m < kModes; ++m) {
    const std::vector<HybridFlight>& flights = run.flights[m];
    const std::vector<double> costs = run.costs(m);
    const apps::Summary ms = apps::summarise(costs);
    out["modes"].push_back(
        {{"name", kHybridModes[m].name},
         {"culler", flights.front().culler},
         {"frames_processed", run.seconds * 1e3 / ms.mean},
         {"min_fps", 1e3 / ms.max},
         {"max_fps", 1e3 / *std::ranges::min_element(costs)},
         {"mean_fps", 1e3 / ms.mean},
         {"mean_ms", ms.mean},
         {"median_ms", ms.median},
         {"visible", mean_visible(flights.back())},
         {"to_cpu", run.ratio(m, 0)},
         {"to_better", run.ratio(m, run.better_path())},
         {"gpu_share", mean_over_passes(flights, share_on_gpu)},
         {"switches", mean_over_passes(flights, [](const HybridFlight& f) { return double(f.switches); })},
         {"probes", mean_over_passes(flights, [](const HybridFlight& f) { return double(f.probes); })},
         {"costs_ms", costs}});
  }
  return out;
}

void print(const json::Value& run, std::FILE* out) {
  static constexpr apps::Column kColumns[] = {{"", "name"},
                                              {"culler", "culler"},
                                              {"frames", "frames_processed", "{:.0f}"},
                                              {"min fps", "min_fps"},
                                              {"max fps", "max_fps"},
                                              {"mean fps", "mean_fps", "{:.5g}"},
                                              {"mean ms", "mean_ms", "{:.4f}"},
                                              {"median", "median_ms", "{:.4f}"},
                                              {"visible", "visible", "{:.0f}"},
                                              {"/cpu", "to_cpu", "{:.3f}"},
                                              {"/better", "to_better", "{:.3f}"},
                                              {"on GPU", "gpu_share", "{:.2f}"},
                                              {"switches", "switches", "{:.1f}"},
                                              {"probes", "probes", "{:.1f}"}};
  std::fprintf(out, "\n%s: %zu items, rendering %s, %zu frames, median of %zu passes; GPU pass %s",
               run["model"].string().c_str(), run["items"].get<std::size_t>(), run["rendering"].string().c_str(),
               run["frames"].get<std::size_t>(), run["passes"].get<std::size_t>(), run["gpu_variant"].string().c_str());
  if (run.contains("gpu_culling_timed_by"))
    std::fprintf(out, "; GPU culling timed by %s", run["gpu_culling_timed_by"].string().c_str());
  std::fprintf(out, "\n\n");
  apps::print_table(run["modes"], kColumns, out);
}

void write_plots(const HybridRun& run, const std::filesystem::path& directory) {
  const std::string stem = (directory / file_name(run)).string();
  const bool aircraft = run.model == "aircraft";
  apps::need(apps::write_text(stem + "_trace.csv", controller_trace(run, 0)));
  if (run.rendering) return apps::need(apps::write_text(stem + "_6_7.svg", figure_svg(run, "6.7", {0, 1, 2})));
  apps::need(apps::write_text(stem + "_6_1.svg", figure_svg(run, aircraft ? "6.2" : "6.1", {0, 1})));
  apps::need(apps::write_text(stem + "_6_5.svg", figure_svg(run, aircraft ? "6.6" : "6.5", {0, 2})));
}

}  // namespace sightline::bench
