// Paths and samples: the types that the controller and its policies share.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <string_view>

#include "sightline/core/api.h"
#include "sightline/core/visible_set.h"

namespace sightline::culling {

class Hierarchy;

/// Which culler takes a frame.
enum class CullPath : std::uint8_t { kCpu, kGpu };

constexpr CullPath other(CullPath path) {
  return path == CullPath::kCpu ? CullPath::kGpu : CullPath::kCpu;
}

/// What a controller is doing.
enum class ControllerState : std::uint8_t {
  kCpu,
  kCpuToGpu,  ///< the dissertation's policy: the CPU was slow, for too few frames yet
  kGpu,
  kGpuToCpu,  ///< the dissertation's policy: the CPU is tried again
  kProbe,     ///< FrameCost: one frame on the other path, to measure it
};
constexpr std::string_view name_of(ControllerState state) {
  constexpr std::string_view kNames[] = {"cpu", "cpu-to-gpu", "gpu", "gpu-to-cpu", "probe"};
  return kNames[std::size_t(state)];
}

/// Samples that come later than this are useless, in frames.
inline constexpr std::uint64_t kOldestSample = 64;

/// What was measured in one frame. NaN: not measured. What a path cannot know (intersections on the GPU) stays NaN.
struct FrameSample {
  static constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();

  std::uint64_t frame = 0;         ///< counted from 0 by Controller::next
  CullPath path = CullPath::kCpu;  ///< that culled it
  double cull_ms = kNotMeasured;
  double frame_ms = kNotMeasured;
  double visible = kNotMeasured;        ///< items
  double tested = kNotMeasured;         ///< boxes, of nodes and of items
  double nodes = kNotMeasured;          ///< boxes that could be tested
  double intersections = kNotMeasured;  ///< boxes of nodes that were found to cross the view volume's surface
  double height = kNotMeasured;         ///< how far down the hierarchy was walked, in levels of a binary one
};

/// Whether a value can be a measured time.
inline bool is_measured(double value) {
  return std::isfinite(value) && value > 0.0;
}

/// Fills in the fields of `sample` that follow from the counters of CpuCuller::cull() with that hierarchy: tested,
/// nodes, intersections and height. A level of the hierarchy counts as four levels of a binary one, a tested leaf as
/// five.
SIGHTLINE_API void describe(const Hierarchy& hierarchy, const core::CullCounters& counters, FrameSample& sample);

}  // namespace sightline::culling
