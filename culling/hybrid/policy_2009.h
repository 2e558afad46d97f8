// The 2009 policy: the hybrid culler's controller of the dissertation that this library implements (section 6.1, figure
// 6.4). The CPU culls until it has been slow for some frames in a row. Then the GPU culls for a fixed number of frames.
// Then the CPU is tried again. "Slow" is an absolute threshold, so the policy never considers what the GPU costs.
#pragma once

#include <cstdint>

#include "sightline/core/api.h"
#include "sightline/culling/hybrid/frame_sample.h"

namespace sightline::culling {

/// What makes a CPU frame slow: the four criteria that the dissertation tried. It settled for time.
enum class Policy2009Trigger : std::uint8_t { kTime, kHeight, kIntersections, kShare };

/// The policy's numbers (section 6.2). Frame counts are at least 1; thresholds are strict.
struct Policy2009Config {
  Policy2009Trigger trigger = Policy2009Trigger::kTime;
  double slow_ms = 0.3;             ///< kTime: cull time
  double slow_height = 20.0;        ///< kHeight: FrameSample::height
  double slow_intersections = 1e4;  ///< kIntersections: FrameSample::intersections
  double slow_share = 0.1;          ///< kShare: FrameSample::tested / nodes
  std::uint32_t enter_frames = 5;   ///< n: slow CPU frames in a row before the GPU takes over
  std::uint32_t gpu_frames = 500;   ///< m: frames of the GPU's turn; doubled each time the CPU is still slow after it
  std::uint32_t probe_frames = 2;   ///< CPU frames of a trial; when all are slow, the GPU takes over again
  std::uint32_t most_gpu_frames = 1u << 20;  ///< limit of the doubling
  friend bool operator==(const Policy2009Config&, const Policy2009Config&) = default;
};

/// See Controller for what the functions promise.
class SIGHTLINE_API Policy2009 {
 public:
  explicit Policy2009(const Policy2009Config& config) : config_(config), stay_(config.gpu_frames) {}

  CullPath next();
  void feed(const FrameSample& sample);
  void scene_changed(double) {}  ///< nothing is learnt, so there is nothing to forget
  void set_gpu(bool ready);

  std::uint64_t switches() const { return switches_; }
  std::uint64_t probes() const { return probes_; }
  ControllerState state() const { return state_; }

 private:
  using State = ControllerState;

  void enter(State state);
  bool is_slow(const FrameSample& sample) const;

  Policy2009Config config_;
  State state_ = State::kCpu;
  bool gpu_ = false;
  std::uint32_t count_ = 0;  // frames that the state has counted
  std::uint32_t stay_;       // m
  std::uint64_t switches_ = 0, probes_ = 0;
};

}  // namespace sightline::culling
