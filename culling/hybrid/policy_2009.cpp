#include "sightline/culling/hybrid/policy_2009.h"

#include <algorithm>

namespace sightline::culling {

CullPath Policy2009::next() {
  if (state_ == State::kGpu) {
    if (count_ < stay_) {
      ++count_;
      return CullPath::kGpu;
    }
    enter(State::kGpuToCpu);
  }
  if (state_ == State::kGpuToCpu) ++probes_;
  return CullPath::kCpu;
}

void Policy2009::feed(const FrameSample& sample) {
  if (sample.path != CullPath::kCpu) return;
  const bool slow = is_slow(sample);
  switch (state_) {
    case State::kCpu:
    case State::kCpuToGpu:
      if (!slow || !gpu_) {
        enter(State::kCpu);
      } else {
        state_ = State::kCpuToGpu;
        if (++count_ >= config_.enter_frames) {
          enter(State::kGpu);
          ++switches_;
        }
      }
      break;
    case State::kGpuToCpu:
      if (!slow) {
        stay_ = config_.gpu_frames;
        enter(State::kCpu);
        ++switches_;
      } else if (++count_ >= config_.probe_frames) {
        stay_ = std::min(2 * stay_, std::max(config_.most_gpu_frames, config_.gpu_frames));
        enter(State::kGpu);
      }
      break;
    case State::kGpu:  // a late sample of the CPU path
    case State::kProbe:
      break;
  }
}

void Policy2009::set_gpu(bool ready) {
  gpu_ = ready;
  if (ready || state_ == State::kCpu) return;
  if (state_ == State::kGpu || state_ == State::kGpuToCpu) ++switches_;
  stay_ = config_.gpu_frames;
  enter(State::kCpu);
}

void Policy2009::enter(State state) {
  state_ = state;
  count_ = 0;
}

/// Comparisons with NaN are false: a frame that was not measured is not slow.
bool Policy2009::is_slow(const FrameSample& sample) const {
  switch (config_.trigger) {
    case Policy2009Trigger::kTime:
      return sample.cull_ms > config_.slow_ms;
    case Policy2009Trigger::kHeight:
      return sample.height > config_.slow_height;
    case Policy2009Trigger::kIntersections:
      return sample.intersections > config_.slow_intersections;
    case Policy2009Trigger::kShare:
      return sample.nodes > 0.0 && sample.tested > config_.slow_share * sample.nodes;
  }
  return false;
}

}  // namespace sightline::culling
