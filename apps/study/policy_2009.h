// The hybrid culler's controller of E. T. Carlos, "Frustum Culling Híbrido Utilizando CPU e GPU" (PUC-Rio, 2009),
// section 6.1 and figure 6.4. The CPU culls until it has been slow for some frames in a row. Then the GPU culls for a
// fixed number of frames. Then the CPU is tried again. "Slow" is an absolute time, so the policy never considers what
// the GPU costs. The dissertation tried three other triggers and gives no results of them.
#pragma once

#include <cstdint>

#include "sightline/apps/common/controller_trace.h"

namespace sightline::study {

/// The policy's numbers (section 6.2). Frame counts are at least 1.
struct Policy2009Config {
  double slow_ms = 0.3;            ///< a CPU frame that culls for longer is slow
  std::uint32_t enter_frames = 5;  ///< n: slow CPU frames in a row before the GPU takes over
  std::uint32_t gpu_frames = 500;  ///< m: frames of the GPU's turn; doubled each time the CPU is still slow after it
  std::uint32_t probe_frames = 2;  ///< CPU frames of a trial; when all are slow, the GPU takes over again
  std::uint32_t most_gpu_frames = 1u << 20;  ///< limit of the doubling
};

class Policy2009 {
 public:
  enum class State : std::uint8_t { kCpu, kCpuToGpu, kGpu, kGpuToCpu };

  explicit Policy2009(const Policy2009Config& config = {}) : config_(config), stay_(config.gpu_frames) {}

  /// The path of the next frame.
  culling::CullPath next();
  /// Takes what was measured in a frame, in the order of frames. Samples of the GPU's path are ignored.
  void feed(const culling::FrameSample& sample);

  /// Changes of the path, without probes.
  std::uint64_t switches() const { return switches_; }
  /// CPU frames of trials.
  std::uint64_t probes() const { return probes_; }
  State state() const { return state_; }

 private:
  void enter(State state);

  Policy2009Config config_;
  State state_ = State::kCpu;
  std::uint32_t count_ = 0;  // frames that the state has counted
  std::uint32_t stay_;       // m
  std::uint64_t switches_ = 0, probes_ = 0;
};

/// Runs the policy over a trace, as apps::run_controller() runs the library's controller.
apps::TraceResult run_2009(const std::vector<apps::TraceFrame>& trace, bool rendering,
                           const Policy2009Config& config = {});

}  // namespace sightline::study
