// Prints and writes the figures of sightline-bench hybrid. Internal to it.
#pragma once

#include <cstdio>
#include <filesystem>

#include "sightline/apps/bench/hybrid/flight.h"
#include "sightline/importers/json/internal/json.h"

namespace sightline::bench {

/// One row of table 6.1 of E. T. Carlos, "Frustum Culling Híbrido Utilizando CPU e GPU" (2009), and figures it lacks.
struct HybridRow {
  double processed = 0.0;                                  ///< frames in the path's duration at this rate
  double least_fps = 0.0, most_fps = 0.0, mean_fps = 0.0;  ///< of frames; the mean is frames divided by time
  double mean_ms = 0.0, median_ms = 0.0, visible = 0.0;    ///< per frame
  double to_cpu = 0.0, to_better = 0.0;                    ///< HybridRun::ratio
  double gpu_share = 0.0, switches = 0.0, probes = 0.0;    ///< means over the passes
};
HybridRow row_of(const HybridRun& run, std::size_t mode);

void print(const HybridRun& run, std::FILE* out);
json::Value to_json(const HybridRun& run);

/// Writes the run's frames as CSV, the first pass as a trace of both paths (apps/common/controller_trace.h), and plots
/// of the figures, frames per second along the path. With rendering off those are 6.1 or 6.2 (CPU and GPU) and 6.5 or
/// 6.6 (the hybrid), with rendering on 6.7. The directory must exist.
core::Expected<void> write_figures(const HybridRun& run, const std::filesystem::path& directory);

}  // namespace sightline::bench
