// When work that is done in portions should pause.
#pragma once

#include <chrono>

namespace sightline::core {

using Deadline = std::chrono::steady_clock::time_point;
inline constexpr Deadline kNoDeadline = Deadline::max();

/// Does not ask the clock where there is no deadline.
inline bool over(Deadline deadline) {
  return deadline != kNoDeadline && std::chrono::steady_clock::now() >= deadline;
}

}  // namespace sightline::core
