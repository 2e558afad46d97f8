// The clock of frames. Internal to engine.
#pragma once

#include <chrono>

namespace sightline::engine {

inline double now_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace sightline::engine
