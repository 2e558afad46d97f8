#include "sightline/core/internal/clock.h"

#include <atomic>
#include <chrono>

namespace sightline::core {
namespace {

double steady_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::atomic<double (*)()> clock_in_use = steady_seconds;

}  // namespace

double now_seconds() {
  return clock_in_use.load(std::memory_order_relaxed)();
}

void use_clock(double (*seconds)()) {
  clock_in_use.store(seconds ? seconds : steady_seconds, std::memory_order_relaxed);
}

}  // namespace sightline::core
