// Helper threads for loops of microseconds to seconds, lent to whoever has jobs.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <thread>
#include <type_traits>
#include <vector>

#include "sightline/core/api.h"

namespace sightline::core {

/// The threads of an application that has some already, such as those of TBB, Qt or OpenMP.
class SIGHTLINE_API JobRunner {
 public:
  virtual ~JobRunner() = default;
  /// So many threads may do jobs at once, the calling one included: 1 or more, always the same.
  virtual int size() const = 0;
  /// Calls job(0) … job(jobs - 1), each once, in any order on any threads; returns when all are done. Jobs take
  /// microseconds to milliseconds, do not throw, and never call this. Two threads do not call it at once for one pool.
  virtual void run(std::uint32_t jobs, const std::function<void(std::uint32_t job)>& job) = 0;
};

/// A fixed number of threads, the calling one among them. Helpers start with the first call that is worth them, spin
/// for some tens of microseconds after each call, and then sleep. They serve one call at a time: a second one meanwhile
/// runs on its own thread, and so does one from within a job of that call. No call allocates once the helpers have
/// started.
///
/// A job is a number, and what it stands for is up to the caller: results depend neither on the number of threads nor
/// on which of them does what. A job must not throw.
class SIGHTLINE_API ThreadPool {
 public:
  /// Number of threads, the calling one included, at most kMost. 0: one per processor, at most kUsual. `runner`: does
  /// what helpers do, with as many threads as it has, and must outlive the pool; null: helpers of the pool's own.
  explicit ThreadPool(int size = 0, JobRunner* runner = nullptr);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  static constexpr int kUsual = 8, kMost = 256;

  int size() const { return size_; }

  /// Calls job(0) … job(jobs - 1), each once, in any order on any of the threads; returns when all are done. Helpers
  /// are called only where that saves time: what is left of a call, as measured on earlier calls and on its first jobs,
  /// must exceed the time to call a spinning helper, or to wake a sleeping one. `most`: so many threads at most, the
  /// calling one included; 0: all.
  template <class Job>
  void run(std::uint32_t jobs, const Job& job, int most = 0) {
    run({jobs, most, call_of(job), &job, nullptr, nullptr});
  }

  struct Nothing {
    void operator()() const {}
  };
  /// run() with helpers that begin at once. `beside` is what the calling thread does before it takes part.
  template <class Job, class Beside = Nothing>
  void run_at_once(std::uint32_t jobs, const Job& job, const Beside& beside = {}, int most = 0) {
    const auto call = [](const void* context) { (*static_cast<const Beside*>(context))(); };
    run({jobs, most, call_of(job), &job, call, &beside});
  }

  /// run() on a pool; on this thread alone where it is null.
  template <class Job>
  static void run_on(ThreadPool* pool, std::uint32_t jobs, const Job& job) {
    if (pool) return pool->run(jobs, job);
    for (std::uint32_t i = 0; i < jobs; ++i) job(i);
  }

 private:
  using Clock = std::chrono::steady_clock;
  struct Call {
    std::uint32_t jobs;
    int most;
    void (*job)(const void* context, std::uint32_t job);
    const void* context;
    void (*beside)(const void* context);  // may be null
    const void* beside_context;
  };

  template <class Job>
  static constexpr auto call_of(const Job&) {
    return [](const void* context, std::uint32_t i) { (*static_cast<const Job*>(context))(i); };
  }
  void run(const Call& call);
  bool help_with(const Call& call, std::uint32_t helpers, std::uint32_t done, std::uint32_t& own);
  /// Return how many jobs the calling thread has done, of those from `done` on.
  std::uint32_t share(const Call& call, std::uint32_t helpers, std::uint32_t done);
  std::uint32_t lend(const Call& call, std::uint32_t threads, std::uint32_t done);
  bool pays(std::uint32_t jobs, Clock::time_point begin) const;
  void start();
  void help(std::uint32_t helper, const std::stop_token& stop);
  template <class Admitted>
  bool work_one(const Admitted& admitted);

  int size_;
  JobRunner* runner_;
  std::vector<std::jthread> helpers_;
  std::atomic_flag busy_;
  // Low half: jobs not yet claimed; high half: number of helpers that may claim them. A helper that comes late finds no
  // jobs, or those of the call that has begun since.
  std::atomic<std::uint64_t> state_{0};
  std::atomic<std::uint32_t> calls_{0};  // on which sleepers wait
  std::atomic<std::uint32_t> finished_{0};
  std::atomic<int> sleeping_{0};
  Call call_{};
  std::atomic<double> job_ns_{0.0};      // smoothed
  std::atomic<Clock::rep> last_end_{0};  // of the last call
};

}  // namespace sightline::core
