// When work that is done in portions should pause.
#pragma once

#include <algorithm>
#include <chrono>

namespace sightline::core {

using Deadline = std::chrono::steady_clock::time_point;
inline constexpr Deadline kNoDeadline = Deadline::max();

/// From now on; none for what is no number, and an hour at most.
inline Deadline deadline_in(double seconds) {
  using Clock = std::chrono::steady_clock;
  const std::chrono::duration<double> time(seconds > 0.0 ? std::min(seconds, 3600.0) : 0.0);
  return Clock::now() + std::chrono::duration_cast<Clock::duration>(time);
}

/// Does not ask the clock where there is no deadline.
inline bool over(Deadline deadline) {
  return deadline != kNoDeadline && std::chrono::steady_clock::now() >= deadline;
}

}  // namespace sightline::core
