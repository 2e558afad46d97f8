// Paths and samples of the hybrid culler's controller.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <string_view>

namespace sightline::culling {

/// Which culler takes a frame.
enum class CullPath : std::uint8_t { kCpu, kGpu };

constexpr CullPath other(CullPath path) {
  return path == CullPath::kCpu ? CullPath::kGpu : CullPath::kCpu;
}

/// What a controller is doing.
enum class ControllerState : std::uint8_t {
  kCpu,
  kGpu,
  kProbe,  ///< one frame on the other path, to measure it
};
constexpr std::string_view name_of(ControllerState state) {
  constexpr std::string_view kNames[] = {"cpu", "gpu", "probe"};
  return kNames[std::size_t(state)];
}

/// Samples that come later than this are useless, in frames.
inline constexpr std::uint64_t kOldestSample = 64;

/// What was measured in one frame. NaN: not measured.
struct FrameSample {
  static constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();

  std::uint64_t frame = 0;         ///< counted from 0 by Controller::next
  CullPath path = CullPath::kCpu;  ///< that culled it
  double cull_ms = kNotMeasured;
  double frame_ms = kNotMeasured;
  double visible = kNotMeasured;  ///< items
};

/// Whether a value can be a measured time.
inline bool is_measured(double value) {
  return std::isfinite(value) && value > 0.0;
}

}  // namespace sightline::culling
