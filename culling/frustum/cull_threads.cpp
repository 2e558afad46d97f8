#include "sightline/culling/frustum/cull_threads.h"

#include <algorithm>
#include <chrono>
#include <exception>

#include "sightline/core/internal/intrinsics.h"

namespace sightline::culling {
namespace {

// Nanoseconds until a helper has begun, when it spins and when it sleeps. Less work is done sooner without it.
constexpr double kCallNs = 3'000.0, kWakeNs = 60'000.0;
constexpr auto kSpin = std::chrono::microseconds(60);
constexpr double kSmoothing = 0.2;

std::chrono::steady_clock::time_point now() {
  return std::chrono::steady_clock::now();
}

}  // namespace

CullThreads::CullThreads(int count) : count_(count > 0 ? count : int(std::thread::hardware_concurrency())) {
  count_ = std::clamp(count_, 1, kMost);
}

CullThreads::~CullThreads() {
  for (std::jthread& helper : helpers_) helper.request_stop();
  state_.fetch_add(std::uint64_t(1) << 32);  // a new query without jobs, which wakes sleepers
  state_.notify_all();
}

void CullThreads::run(std::uint32_t jobs, Call call, const void* context, const std::function<void()>& beside) {
  const auto begin = now();
  std::uint32_t own = jobs;
  const bool helps = count_ > 1 && (beside ? jobs > 0 : jobs > 1 && pays(jobs, begin));
  if (helps && !busy_.test_and_set(std::memory_order_acquire)) {
    own = share(jobs, call, context, beside);
    busy_.clear(std::memory_order_release);
  } else {
    if (beside) beside();
    for (std::uint32_t i = 0; i < jobs; ++i) call(context, i);
  }
  const auto end = now();
  last_end_.store(end.time_since_epoch().count(), std::memory_order_relaxed);
  if (own == 0 || beside) return;
  const double each = std::chrono::duration<double, std::nano>(end - begin).count() / own;
  const double known = job_ns_.load(std::memory_order_relaxed);
  job_ns_.store(known == 0.0 ? each : known + kSmoothing * (each - known), std::memory_order_relaxed);
}

/// Sleeping helpers are woken even for a short query when queries follow each other closely: later queries then find
/// them awake.
bool CullThreads::pays(std::uint32_t jobs, Clock::time_point begin) const {
  const Clock::duration pause = begin.time_since_epoch() - Clock::duration(last_end_.load(std::memory_order_relaxed));
  const double left_to_helpers = job_ns_.load(std::memory_order_relaxed) * (jobs - 1);
  return left_to_helpers > (pause < kSpin ? kCallNs : kWakeNs);
}

std::uint32_t CullThreads::share(std::uint32_t jobs, Call call, const void* context,
                                 const std::function<void()>& beside) {
  if (helpers_.empty()) start();
  call_ = call;
  context_ = context;
  finished_.store(0, std::memory_order_relaxed);
  const std::uint64_t query = (state_.load(std::memory_order_relaxed) >> 32) + 1;
  state_.store(query << 32 | jobs);
  if (sleeping_.load() > 0) state_.notify_all();
  if (beside) beside();
  std::uint32_t own = 0;
  while (work_one()) ++own;
  while (finished_.load(std::memory_order_acquire) != jobs) core::pause();
  return own;
}

/// Where a thread cannot be made, for want of memory or by a limit, those that there are do the work.
void CullThreads::start() {
  try {
    for (int i = 1; i < count_; ++i) helpers_.emplace_back([this](const std::stop_token& stop) { help(stop); });
  } catch (const std::exception&) {
  }
}

/// Claims a job and does it; false when none is left.
bool CullThreads::work_one() {
  std::uint64_t state = state_.load(std::memory_order_acquire);
  do {
    if (std::uint32_t(state) == 0) return false;
  } while (!state_.compare_exchange_weak(state, state - 1, std::memory_order_acquire));
  call_(context_, std::uint32_t(state) - 1);
  finished_.fetch_add(1, std::memory_order_release);
  return true;
}

void CullThreads::help(const std::stop_token& stop) {
  auto worked = now();
  while (!stop.stop_requested()) {
    if (work_one()) {
      worked = now();
    } else if (now() - worked < kSpin) {
      core::pause();
    } else {
      const std::uint64_t seen = state_.load();
      if (std::uint32_t(seen) != 0) continue;
      if (stop.stop_requested()) return;  // asked after `seen` was read: the destructor changes the state after asking
      ++sleeping_;
      state_.wait(seen);
      --sleeping_;
      worked = now();
    }
  }
}

}  // namespace sightline::culling
