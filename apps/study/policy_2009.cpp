#include "sightline/apps/study/policy_2009.h"

#include <algorithm>

namespace sightline::study {

using culling::CullPath;

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

void Policy2009::feed(const culling::FrameSample& sample) {
  if (sample.path != CullPath::kCpu) return;
  const bool slow = sample.cull_ms > config_.slow_ms;  // a frame that was not measured (NaN) is not slow
  switch (state_) {
    case State::kCpu:
    case State::kCpuToGpu:
      if (!slow) {
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
      break;
  }
}

void Policy2009::enter(State state) {
  state_ = state;
  count_ = 0;
}

apps::TraceResult run_2009(const std::vector<apps::TraceFrame>& trace, bool rendering, const Policy2009Config& config) {
  Policy2009 policy(config);
  apps::TraceResult result = apps::run_choice(
      trace, rendering, [&] { return policy.next(); },
      [&](const culling::FrameSample& sample) { policy.feed(sample); });
  result.switches = policy.switches();
  result.probes = policy.probes();
  return result;
}

}  // namespace sightline::study
