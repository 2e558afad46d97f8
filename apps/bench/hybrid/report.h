// Prints and writes the results of sightline-bench hybrid. Internal to it.
#pragma once

#include <cstdio>
#include <filesystem>

#include "sightline/apps/bench/hybrid/flight.h"
#include "sightline/importers/json/internal/json.h"

namespace sightline::bench {

/// Results of a run. "modes" are the rows of table 6.1 of E. T. Carlos, "Frustum Culling Híbrido Utilizando CPU e GPU"
/// (2009), and statistics that it lacks: "frames_processed" in the path's duration at this rate, frames a second,
/// milliseconds and visible items of a frame, HybridRun::ratio, and means over the passes.
json::Value to_json(const HybridRun& run);
/// Prints what to_json() gives.
void print(const json::Value& run, std::FILE* out);

/// Writes the first pass as a trace of both paths (apps/common/controller_trace.h), and plots of the dissertation's
/// figures, frames per second along the path. With rendering off those are 6.1 or 6.2 (CPU and GPU) and 6.5 or 6.6 (the
/// hybrid), with rendering on 6.7. The directory must exist.
void write_plots(const HybridRun& run, const std::filesystem::path& directory);

}  // namespace sightline::bench
