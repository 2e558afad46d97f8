// Helper threads that cull several views of one query in parallel.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <thread>
#include <vector>

#include "sightline/core/api.h"

namespace sightline::culling {

/// Helper threads for CpuCuller::cull() with several views. They start with the first query that is worth them, spin
/// for some tens of microseconds after each query, and then sleep. They serve one query at a time: a second one
/// meanwhile runs on its own thread.
///
/// Helpers are called only where that saves time. What is left of a query, as measured on earlier queries, must exceed
/// the time to call a spinning helper, or to wake a sleeping one. Results never depend on it.
class SIGHTLINE_API CullThreads {
 public:
  /// Number of threads, the calling one included: 1 or more. 0: one per processor, at most kMost.
  explicit CullThreads(int count = 0);
  ~CullThreads();
  CullThreads(const CullThreads&) = delete;
  CullThreads& operator=(const CullThreads&) = delete;

  static constexpr int kMost = 8;

  int count() const { return count_; }

  /// Calls job(0) … job(jobs - 1), each once, in any order on any of the threads; returns when all are done. `beside`,
  /// if there is any: what the calling thread does first, while helpers begin.
  template <class Job>
  void run(std::uint32_t jobs, const Job& job, const std::function<void()>& beside = {}) {
    run(
        jobs, [](const void* context, std::uint32_t i) { (*static_cast<const Job*>(context))(i); }, &job, beside);
  }

 private:
  using Clock = std::chrono::steady_clock;
  using Call = void (*)(const void* context, std::uint32_t job);

  void run(std::uint32_t jobs, Call call, const void* context, const std::function<void()>& beside);
  /// Returns how many jobs the calling thread has done.
  std::uint32_t share(std::uint32_t jobs, Call call, const void* context, const std::function<void()>& beside);
  bool pays(std::uint32_t jobs, Clock::time_point begin) const;
  void start();
  void help(const std::stop_token& stop);
  bool work_one();

  int count_;
  std::vector<std::jthread> helpers_;
  std::atomic_flag busy_;
  // Low half: jobs not yet claimed; high half: number of the query. Both are one word, so that a late helper cannot
  // claim a job of a query that it has not seen.
  std::atomic<std::uint64_t> state_{0};
  std::atomic<std::uint32_t> finished_{0};
  std::atomic<int> sleeping_{0};
  Call call_ = nullptr;
  const void* context_ = nullptr;
  std::atomic<double> job_ns_{0.0};      // smoothed
  std::atomic<Clock::rep> last_end_{0};  // of the last query
};

}  // namespace sightline::culling
