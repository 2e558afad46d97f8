#include "sightline/apps/common/controller_trace.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <optional>
#include <sstream>

#include "sightline/importers/internal/text_scanner.h"

namespace sightline::apps {
namespace {

using culling::CullPath;
using culling::FrameSample;

struct Column {
  std::string_view name;
  double TraceFrame::*field;  // null: the frame number
  bool time;
};

constexpr std::array<Column, 6> kColumns = {{{"frame", nullptr, false},
                                             {"visible", &TraceFrame::visible, false},
                                             {"cpu_cull_ms", &TraceFrame::cpu_cull_ms, true},
                                             {"cpu_frame_ms", &TraceFrame::cpu_frame_ms, true},
                                             {"gpu_cull_ms", &TraceFrame::gpu_cull_ms, true},
                                             {"gpu_frame_ms", &TraceFrame::gpu_frame_ms, true}}};

/// Limit of times, counts and frame numbers. Larger numbers cannot be summed, nor written and read again.
constexpr double kLargest = 1e15;

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (std::size_t begin = 0;;) {
    const std::size_t end = text.find(separator, begin);
    parts.push_back(importers::trimmed(text.substr(begin, end - begin)));
    if (end == std::string_view::npos) return parts;
    begin = end + 1;
  }
}

std::optional<double> parse_number(std::string_view text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// The meaning of each column of a trace; null where it is skipped.
using Layout = std::vector<const Column*>;

core::Expected<Layout> parse_header(std::string_view line) {
  Layout layout;
  for (const std::string_view name : split(line, ',')) {
    const auto found = std::find_if(kColumns.begin(), kColumns.end(), [&](const Column& c) { return c.name == name; });
    const Column* column = found == kColumns.end() ? nullptr : &*found;
    if (column && std::find(layout.begin(), layout.end(), column) != layout.end())
      return core::fail("column " + std::string(name) + " twice");
    layout.push_back(column);
  }
  for (const Column& column : kColumns)
    if (std::find(layout.begin(), layout.end(), &column) == layout.end())
      return core::fail("no column " + std::string(column.name));
  return layout;
}

core::Expected<TraceFrame> parse_frame(std::string_view line, const Layout& layout, std::optional<double>& last) {
  const auto fields = split(line, ',');
  if (fields.size() != layout.size())
    return core::fail(std::to_string(layout.size()) + " fields expected, found " + std::to_string(fields.size()));
  TraceFrame frame{};
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const Column* column = layout[i];
    if (!column) continue;
    const auto value = parse_number(fields[i]);
    const std::string what = std::string(column->name) + ": '" + std::string(fields[i]) + "' is no ";
    if (!value) return core::fail(what + "number");
    if (column->field) {
      const bool good = std::isnan(*value) || (*value <= kLargest && (column->time ? *value > 0.0 : *value >= 0.0));
      if (!good)
        return core::fail(what + (column->time ? "time > 0" : "count >= 0") +
                          (*value > kLargest ? " and <= 1e15" : ""));
      frame.*column->field = *value;
    } else {
      if (*value != std::floor(*value) || std::abs(*value) > kLargest) return core::fail(what + "frame number");
      if (last && *value != *last + 1.0) return core::fail(what + "successor of the frame before");
      last = *value;
    }
  }
  return frame;
}

}  // namespace

core::Expected<std::vector<TraceFrame>> parse_controller_trace(std::string_view text, const std::string& name) {
  const auto fail = [&](std::size_t line, const std::string& message) {
    return core::fail(name + ":" + std::to_string(line) + ": " + message);
  };
  const auto lines = split(text, '\n');
  const auto layout = parse_header(lines[0]);
  if (!layout) return fail(1, layout.error().message);
  std::vector<TraceFrame> trace;
  std::optional<double> last;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    if (lines[i].empty()) continue;
    auto frame = parse_frame(lines[i], *layout, last);
    if (!frame) return fail(i + 1, frame.error().message);
    trace.push_back(*frame);
  }
  if (trace.empty()) return fail(lines.size(), "no frames");
  return trace;
}

core::Expected<std::vector<TraceFrame>> read_controller_trace(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  if (!in || !(text << in.rdbuf())) return core::fail(file + ": cannot be read, or is empty");
  return parse_controller_trace(text.str(), file);
}

std::string controller_trace_csv(const std::vector<TraceFrame>& trace) {
  std::string csv;
  for (const Column& column : kColumns) csv += (csv.empty() ? "" : ",") + std::string(column.name);
  csv += '\n';
  char number[40];
  for (std::size_t i = 0; i < trace.size(); ++i) {
    csv += std::to_string(i);
    for (const Column& column : kColumns) {
      if (!column.field) continue;
      const double value = trace[i].*column.field;
      std::snprintf(number, sizeof number, ",%.*g", column.time ? 6 : 15, value);
      csv += std::isnan(value) ? ",nan" : number;
    }
    csv += '\n';
  }
  return csv;
}

TraceResult run_choice(const std::vector<TraceFrame>& trace, bool rendering, const std::function<CullPath()>& next,
                       const std::function<void(const FrameSample&)>& feed) {
  TraceResult result;
  const auto show = [&](std::size_t i, CullPath path) {
    const TraceFrame& f = trace[i];
    feed({.frame = i,
          .path = path,
          .cull_ms = f.cost(path, false),
          .frame_ms = f.cost(path, true),
          .visible = f.visible});
  };
  const auto known = [](double ms) { return std::isnan(ms) ? 0.0 : ms; };
  double fixed[2] = {0.0, 0.0};
  for (std::size_t i = 0; i < trace.size(); ++i) {
    const CullPath path = next();
    result.choice += path == CullPath::kCpu ? 'c' : 'g';
    if (i >= kGpuLatency && result.choice[i - kGpuLatency] == 'g') show(i - kGpuLatency, CullPath::kGpu);
    if (path == CullPath::kCpu) show(i, path);
    const double cpu = known(trace[i].cost(CullPath::kCpu, rendering)),
                 gpu = known(trace[i].cost(CullPath::kGpu, rendering));
    result.chosen_ms += path == CullPath::kCpu ? cpu : gpu;
    result.oracle_ms += std::min(cpu, gpu);
    fixed[0] += cpu;
    fixed[1] += gpu;
  }
  result.best_fixed_ms = std::min(fixed[0], fixed[1]);
  return result;
}

TraceResult run_controller(const std::vector<TraceFrame>& trace, bool rendering,
                           const culling::ControllerConfig& config) {
  culling::ControllerConfig used = config;
  used.rendering = rendering;
  culling::Controller controller(used);
  double items = 0.0;
  for (const TraceFrame& f : trace) items = std::max(items, std::isnan(f.visible) ? 0.0 : f.visible);
  controller.scene_changed(items);
  controller.gpu_ready();
  TraceResult result = run_choice(
      trace, rendering, [&] { return controller.next(); }, [&](const FrameSample& sample) { controller.feed(sample); });
  result.switches = controller.switches();
  result.probes = controller.probes();
  return result;
}

}  // namespace sightline::apps
