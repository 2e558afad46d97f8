// Recorded traces of the cost of both culling paths, frame by frame, and runs of the hybrid's controller over them.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/core/error.h"
#include "sightline/culling/hybrid/controller.h"

namespace sightline::apps {

/// One frame of a trace: the cost of both paths, milliseconds. NaN: not measured.
struct TraceFrame {
  double cpu_cull_ms, cpu_frame_ms, gpu_cull_ms, gpu_frame_ms;
  double visible = culling::FrameSample::kNotMeasured;

  double cost(culling::CullPath path, bool rendering) const {
    if (path == culling::CullPath::kCpu) return rendering ? cpu_frame_ms : cpu_cull_ms;
    return rendering ? gpu_frame_ms : gpu_cull_ms;
  }
};

/// Parses CSV. A header names the columns, in any order: frame, visible, cpu_cull_ms, cpu_frame_ms, gpu_cull_ms,
/// gpu_frame_ms. Other columns are skipped. Times are > 0 or "nan", counts >= 0, nothing exceeds 1e15, frames rise by
/// one. There must be at least one frame. Errors name the line, and call the text `name`.
core::Expected<std::vector<TraceFrame>> parse_controller_trace(std::string_view text, const std::string& name);
core::Expected<std::vector<TraceFrame>> read_controller_trace(const std::string& file);
/// Writes all columns, in the form that parse_controller_trace reads.
std::string controller_trace_csv(const std::vector<TraceFrame>& trace);

struct TraceResult {
  double chosen_ms = 0.0;      ///< sum over the paths chosen
  double oracle_ms = 0.0;      ///< sum over the cheaper path of every frame
  double best_fixed_ms = 0.0;  ///< the cheaper of always-CPU and always-GPU
  std::uint64_t switches = 0, probes = 0;
  std::string choice;  ///< per frame 'c' or 'g'
};

/// GPU samples arrive this many frames late.
inline constexpr std::size_t kGpuLatency = 2;

/// Runs a choice of paths over a trace: `next` gives the path of a frame, and `feed` gets what the frame cost on it.
/// The CPU's sample of a frame arrives before the next frame, the GPU's kGpuLatency frames later. A cost that was not
/// measured counts as 0. The result lacks switches and probes.
TraceResult run_choice(const std::vector<TraceFrame>& trace, bool rendering,
                       const std::function<culling::CullPath()>& next,
                       const std::function<void(const culling::FrameSample&)>& feed);

/// Runs the controller over a trace. The number of items is taken to be the largest number visible.
TraceResult run_controller(const std::vector<TraceFrame>& trace, bool rendering,
                           const culling::ControllerConfig& config = {});

}  // namespace sightline::apps
