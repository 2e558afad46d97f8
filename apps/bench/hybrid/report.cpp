#include "sightline/apps/bench/hybrid/report.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "sightline/apps/bench/harness.h"
#include "sightline/apps/common/controller_trace.h"
#include "sightline/apps/common/output.h"
#include "sightline/apps/common/svg_plot.h"

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

std::string frames_csv(const HybridRun& run) {
  std::array<std::vector<double>, kModes> costs;
  std::string csv = "frame,visible";
  for (std::size_t m = 0; m < kModes; ++m) {
    costs[m] = run.costs(m);
    for (const char* column : {" ms", " path of the last pass"})
      csv += ',' + std::string(kHybridModes[m].name) + column;
  }
  csv += '\n';
  char number[40];
  for (std::size_t i = 0; i < run.frames(); ++i) {
    csv += std::to_string(i) + ',' + std::to_string(run.flights[0].back().frames[i].visible);
    for (std::size_t m = 0; m < kModes; ++m) {
      std::snprintf(number, sizeof number, ",%.6f", costs[m][i]);
      csv += std::string(number) + (run.flights[m].back().frames[i].on_gpu ? ",gpu" : ",cpu");
    }
    csv += '\n';
  }
  return csv;
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

HybridRow row_of(const HybridRun& run, std::size_t mode) {
  const std::vector<double> costs = run.costs(mode);
  const std::vector<HybridFlight>& flights = run.flights[mode];
  const auto [least, most] = std::minmax_element(costs.begin(), costs.end());
  HybridRow row;
  row.mean_ms = std::accumulate(costs.begin(), costs.end(), 0.0) / double(costs.size());
  row.median_ms = apps::median(costs);
  row.mean_fps = 1e3 / row.mean_ms;
  row.least_fps = 1e3 / *most;
  row.most_fps = 1e3 / *least;
  row.processed = run.seconds * row.mean_fps;
  row.visible = mean_visible(flights.back());
  row.to_cpu = run.ratio(mode, 0);
  row.to_better = run.ratio(mode, run.better_path());
  row.gpu_share = mean_over_passes(flights, share_on_gpu);
  row.switches = mean_over_passes(flights, [](const HybridFlight& f) { return double(f.switches); });
  row.probes = mean_over_passes(flights, [](const HybridFlight& f) { return double(f.probes); });
  return row;
}

void print(const HybridRun& run, std::FILE* out) {
  std::fprintf(out, "\n%s: %zu items, rendering %s, %zu frames, median of %zu passes", run.model.c_str(), run.items,
               run.rendering ? "on" : "off", run.frames(), run.flights[0].size());
  std::fprintf(out, "; GPU pass %s", run.flights[1].front().gpu_variant.c_str());
  if (!run.rendering) std::fprintf(out, "; GPU culling timed by %s", how_off_is_timed(run));
  std::fprintf(out, "\n%-18s %10s %9s %9s %9s %9s %9s %9s %7s %7s %6s %7s %7s\n", "", "frames", "min fps", "max fps",
               "mean fps", "mean ms", "median", "visible", "/cpu", "/better", "% GPU", "switch", "probes");
  for (std::size_t m = 0; m < kModes; ++m) {
    const HybridRow r = row_of(run, m);
    const std::string& culler = run.flights[m].front().culler;
    const bool small = kHybridModes[m].culler == engine::CullerChoice::kHybrid && culler != "hybrid";
    std::fprintf(out, "%-18s %10.0f %9.4g %9.4g %9.5g %9.4f %9.4f %9.0f %7.3f %7.3f %6.0f %7.1f %7.1f%s\n",
                 kHybridModes[m].name, r.processed, r.least_fps, r.most_fps, r.mean_fps, r.mean_ms, r.median_ms,
                 r.visible, r.to_cpu, r.to_better, 100.0 * r.gpu_share, r.switches, r.probes,
                 small ? ("  (few items: " + culler + ")").c_str() : "");
  }
}

json::Value to_json(const HybridRun& run) {
  json::Value out = {{"model", run.model},
                     {"items", run.items},
                     {"rendering", run.rendering ? "on" : "off"},
                     {"gpu_variant", run.flights[1].front().gpu_variant},
                     {"frames", run.frames()},
                     {"passes", run.flights[0].size()},
                     {"better_path", kHybridModes[run.better_path()].name}};
  for (std::size_t m = 0; m < kModes; ++m) {
    const HybridRow r = row_of(run, m);
    out["modes"].push_back({{"name", kHybridModes[m].name},
                            {"culler", run.flights[m].front().culler},
                            {"frames_processed", r.processed},
                            {"min_fps", r.least_fps},
                            {"max_fps", r.most_fps},
                            {"mean_fps", r.mean_fps},
                            {"mean_ms", r.mean_ms},
                            {"median_ms", r.median_ms},
                            {"visible", r.visible},
                            {"to_cpu", r.to_cpu},
                            {"to_better", r.to_better},
                            {"gpu_share", r.gpu_share},
                            {"switches", r.switches},
                            {"probes", r.probes},
                            {"costs_ms", run.costs(m)}});
  }
  return out;
}

core::Expected<void> write_figures(const HybridRun& run, const std::filesystem::path& directory) {
  const std::string stem = (directory / file_name(run)).string();
  const bool aircraft = run.model == "aircraft";
  auto done = apps::write_text(stem + ".csv", frames_csv(run));
  if (done) done = apps::write_text(stem + "_trace.csv", controller_trace(run, 0));
  if (run.rendering) {
    if (done) done = apps::write_text(stem + "_6_7.svg", figure_svg(run, "6.7", {0, 1, 2}));
    return done;
  }
  if (done) done = apps::write_text(stem + "_6_1.svg", figure_svg(run, aircraft ? "6.2" : "6.1", {0, 1}));
  if (done) done = apps::write_text(stem + "_6_5.svg", figure_svg(run, aircraft ? "6.6" : "6.5", {0, 2}));
  return done;
}

}  // namespace sightline::bench
