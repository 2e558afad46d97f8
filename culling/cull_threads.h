// Threads that take views off the calling thread when several are culled at once.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <thread>
#include <vector>

namespace sightline::culling {

/// Helpers for CpuCuller::cull() with several views. They start with the first query that is worth them, spin for some
/// tens of microseconds after each, and then sleep. One query at a time: a second one meanwhile runs on its own thread.
///
/// Whether helpers are asked is decided by time: what is left of a query, measured on those before, must exceed what it
/// takes to call a helper that spins, or to wake one that sleeps. Answers never depend on it.
class CullThreads {
 public:
  /// Threads in all, the calling one included: 1 or more. 0: one per processor, at most kMost.
  explicit CullThreads(int count = 0);
  ~CullThreads();
  CullThreads(const CullThreads&) = delete;
  CullThreads& operator=(const CullThreads&) = delete;

  static constexpr int kMost = 8;

  int count() const { return count_; }

  /// Calls job(0) … job(jobs - 1), each once, in any order on any of the threads; returns when all are done.
  template <class Job>
  void run(std::uint32_t jobs, const Job& job) {
    run(
        jobs, [](const void* context, std::uint32_t i) { (*static_cast<const Job*>(context))(i); }, &job);
  }

 private:
  using Clock = std::chrono::steady_clock;
  using Call = void (*)(const void* context, std::uint32_t job);

  void run(std::uint32_t jobs, Call call, const void* context);
  std::uint32_t share(std::uint32_t jobs, Call call, const void* context);  // jobs done by the calling thread
  bool pays(std::uint32_t jobs, Clock::time_point begin) const;
  void start();
  void help(const std::stop_token& stop);
  bool work_one();

  int count_;
  std::vector<std::jthread> helpers_;
  std::atomic_flag busy_;
  // Jobs not yet claimed in the low half, the number of the query above: one word, so that a helper that comes late
  // cannot claim a job of a query it has not seen.
  std::atomic<std::uint64_t> state_{0};
  std::atomic<std::uint32_t> finished_{0};
  std::atomic<int> sleeping_{0};
  Call call_ = nullptr;
  const void* context_ = nullptr;
  std::atomic<double> job_ns_{0.0};      // smoothed
  std::atomic<Clock::rep> last_end_{0};  // of the last query
};

}  // namespace sightline::culling
