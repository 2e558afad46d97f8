#include "sightline/core/thread_pool.h"

#include <algorithm>
#include <bit>
#include <exception>

#include "sightline/core/internal/intrinsics.h"
#include "sightline/core/internal/platform/threads.h"

namespace sightline::core {
namespace {

// Nanoseconds until a helper has begun, when it spins and when it sleeps. Less work is done sooner without it.
constexpr double kCallNs = 3'000.0, kWakeNs = 60'000.0;
constexpr auto kSpin = std::chrono::microseconds(60), kLongRest = 2 * kSpin;
constexpr double kSmoothing = 0.2;

std::chrono::steady_clock::time_point now() {
  return std::chrono::steady_clock::now();
}

int size_of(int asked_for, const JobRunner* runner) {
  if (runner) return runner->size();
  return asked_for > 0 ? asked_for : std::min(int(std::thread::hardware_concurrency()), ThreadPool::kUsual);
}

}  // namespace

ThreadPool::ThreadPool(int size, JobRunner* runner)
    : size_(std::clamp(size_of(size, runner), 1, kMost)), runner_(runner) {}

ThreadPool::~ThreadPool() {
  for (std::jthread& helper : helpers_) helper.request_stop();
  ++calls_;
  platform::wake_all(calls_);
}

void ThreadPool::run(const Call& call) {
  const auto begin = now();
  const std::uint32_t helpers = std::uint32_t((call.most > 0 ? std::min(call.most, size_) : size_) - 1);
  std::uint32_t own = 0, done = 0;
  bool helped = (call.beside ? call.jobs > 0 : pays(call.jobs, begin)) && help_with(call, helpers, done, own);
  if (!helped && call.beside) call.beside(call.beside_context);
  while (!helped && done < call.jobs) {
    call.job(call.context, done++);
    // Earlier calls may have had shorter jobs than this one.
    if (std::has_single_bit(done) && (now() - begin) / done * (call.jobs - done) > kLongRest)
      helped = !call.beside && help_with(call, helpers, done, own);
  }
  own += done;
  const auto end = now();
  last_end_.store(end.time_since_epoch().count(), std::memory_order_relaxed);
  if (call.jobs < 2 || own == 0 || call.beside) return;
  const double each = std::chrono::duration<double, std::nano>(end - begin).count() / own;
  const double known = job_ns_.load(std::memory_order_relaxed);
  job_ns_.store(known == 0.0 ? each : known + kSmoothing * (each - known), std::memory_order_relaxed);
}

/// Does jobs `done` and on with helpers, unless these serve another call. Sets `own`, how many the calling thread did.
bool ThreadPool::help_with(const Call& call, std::uint32_t helpers, std::uint32_t done, std::uint32_t& own) {
  if (helpers == 0 || busy_.test_and_set(std::memory_order_acquire)) return false;
  own = runner_ ? lend(call, helpers + 1, done) : share(call, helpers, done);
  busy_.clear(std::memory_order_release);
  return true;
}

/// Sleeping helpers are woken even for a short call when calls follow each other closely: later calls then find them
/// awake.
bool ThreadPool::pays(std::uint32_t jobs, Clock::time_point begin) const {
  if (jobs < 2) return false;
  const Clock::duration pause = begin.time_since_epoch() - Clock::duration(last_end_.load(std::memory_order_relaxed));
  const double left_to_helpers = job_ns_.load(std::memory_order_relaxed) * (jobs - 1);
  return left_to_helpers > (pause < kSpin ? kCallNs : kWakeNs);
}

std::uint32_t ThreadPool::share(const Call& call, std::uint32_t helpers, std::uint32_t done) {
  if (helpers_.empty()) start();
  call_ = call;
  finished_.store(done, std::memory_order_relaxed);
  state_.store(std::uint64_t(helpers) << 32 | (call.jobs - done));
  ++calls_;
  if (sleeping_.load() > 0) platform::wake_all(calls_);
  if (call.beside) call.beside(call.beside_context);
  std::uint32_t own = 0;
  while (work_one([](std::uint64_t) { return true; })) ++own;
  while (finished_.load(std::memory_order_acquire) != call.jobs) pause();
  return own;
}

/// As many jobs of the runner's as threads may take part, where these are fewer than it has.
std::uint32_t ThreadPool::lend(const Call& call, std::uint32_t threads, std::uint32_t done) {
  if (call.beside) call.beside(call.beside_context);
  const std::uint32_t left = call.jobs - done, parts = threads < std::uint32_t(size_) ? std::min(threads, left) : left;
  runner_->run(parts, [&](std::uint32_t part) {
    for (std::uint32_t i = done + part; i < call.jobs; i += parts) call.job(call.context, i);
  });
  return (left + threads - 1) / threads;
}

/// Where a thread cannot be made, for want of memory or by a limit, those that there are do the work.
void ThreadPool::start() {
  try {
    for (std::uint32_t i = 0; i + 1 < std::uint32_t(size_); ++i)
      helpers_.emplace_back([this, i](const std::stop_token& stop) { help(i, stop); });
  } catch (const std::exception&) {
  }
}

/// Claims a job and does it; false when none is left, or none for this thread: admitted(the number of helpers).
template <class Admitted>
bool ThreadPool::work_one(const Admitted& admitted) {
  std::uint64_t state = state_.load(std::memory_order_acquire);
  do {
    if (std::uint32_t(state) == 0 || !admitted(state >> 32)) return false;
  } while (!state_.compare_exchange_weak(state, state - 1, std::memory_order_acquire));
  call_.job(call_.context, call_.jobs - std::uint32_t(state));
  finished_.fetch_add(1, std::memory_order_release);
  return true;
}

void ThreadPool::help(std::uint32_t helper, const std::stop_token& stop) {
  auto worked = now();
  for (;;) {
    const std::uint32_t seen = calls_.load();
    if (stop.stop_requested()) return;  // asked before the destructor's call, which wakes whoever has not seen it
    if (work_one([helper](std::uint64_t helpers) { return helper < helpers; })) {
      worked = now();
    } else if (now() - worked < kSpin) {
      pause();
    } else {
      ++sleeping_;
      platform::wait_while(calls_, seen);
      --sleeping_;
      worked = now();
    }
  }
}

}  // namespace sightline::core
