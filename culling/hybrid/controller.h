// Which path culls the next frame, the CPU's or the GPU's: pure logic, fed with measured times, without GL or a clock
// of its own. Two policies. FrameCost (the default) estimates what either path would cost and takes the cheaper one;
// Policy2009 is the state machine of the dissertation that this library grew from, kept as the baseline.
// docs/results/hybrid.md has the formulas and how close either comes to the best choice of every frame.
//
//   controller.scene_changed(items); controller.gpu_ready();
//   loop: path = controller.next(); …cull and draw…; controller.feed(what is known by now of this and earlier frames);
#pragma once

#include <cstdint>
#include <variant>

#include "sightline/core/api.h"
#include "sightline/culling/hybrid/frame_cost.h"
#include "sightline/culling/hybrid/frame_sample.h"
#include "sightline/culling/hybrid/policy_2009.h"

namespace sightline::culling {

enum class Policy : std::uint8_t { kFrameCost, k2009 };

struct ControllerConfig {
  Policy policy = Policy::kFrameCost;
  FrameCostConfig frame_cost;
  Policy2009Config policy_2009;
  friend bool operator==(const ControllerConfig&, const ControllerConfig&) = default;
};

/// Deterministic: the same calls give the same paths. Allocates nothing; copies are independent. Starts on the CPU, and
/// stays there until gpu_ready().
class SIGHTLINE_API Controller {
 public:
  explicit Controller(const ControllerConfig& config = {});

  /// The path of the next frame. Frames are numbered 0, 1, … by the calls.
  CullPath next();

  /// Takes what was measured in a frame, as soon as it is known. Samples of GPU frames come late, and some never come.
  /// Samples of frames not yet begun, older than the newest one of their path, or older than kOldestSample frames are
  /// ignored; so is each figure that is not finite and positive.
  void feed(const FrameSample& sample);

  /// The scene has changed (a commit, a new generation) and has so many items now. What was learnt is only a first
  /// guess from here on. Call it before the first frame, too. 0: the number is not known.
  void scene_changed(double items);
  /// The application stood still (a pause, a dialog, a breakpoint): frames up to the next one are not measured.
  void paused();
  /// The GPU path is unavailable: the CPU culls every frame.
  void gpu_lost();
  /// The GPU path is available (again) and warmed up: shaders compiled, buffers filled.
  void gpu_ready();

  /// Frames so far.
  std::uint64_t frames() const { return frames_; }
  /// Changes of the path, without probes.
  std::uint64_t switches() const;
  /// Probes: frames taken on the other path only to measure it.
  std::uint64_t probes() const;
  ControllerState state() const;

 private:
  std::variant<FrameCost, Policy2009> policy_;
  std::uint64_t frames_ = 0, measured_from_ = 0;
  std::uint64_t newest_[2] = {0, 0};  // frame after the newest sample, per path
};

}  // namespace sightline::culling
