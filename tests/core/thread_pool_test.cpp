// Jobs shared out among threads: each once, by no more threads than allowed.
#include "sightline/core/thread_pool.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <set>
#include <thread>

#include <gtest/gtest.h>

#include "sightline/tests/support/application_threads.h"

namespace sightline::tests::thread_pool_test {
namespace {

using core::ThreadPool;

void work_for(std::chrono::microseconds time) {
  const auto end = std::chrono::steady_clock::now() + time;
  while (std::chrono::steady_clock::now() < end) {
  }
}

/// Counts how often each job runs. Long jobs are worth a helper, short ones are not.
void expect_each_once(ThreadPool& threads, std::uint32_t jobs, std::chrono::microseconds time) {
  const std::unique_ptr<std::atomic<int>[]> runs(new std::atomic<int>[jobs + 1]);
  for (std::uint32_t i = 0; i <= jobs; ++i) runs[i] = 0;
  threads.run(jobs, [&](std::uint32_t i) {
    work_for(time);
    ++runs[i];
  });
  for (std::uint32_t i = 0; i < jobs; ++i) ASSERT_EQ(runs[i], 1) << "job " << i << " of " << jobs;
  ASSERT_EQ(runs[jobs], 0);
}

TEST(ThreadPool, EveryJobRunsOnce) {
  for (int count = 1; count <= 4; ++count) {
    SCOPED_TRACE(count);
    ThreadPool threads(count);
    EXPECT_EQ(threads.size(), count);
    for (std::uint32_t round = 0; round < 300; ++round) {
      ASSERT_NO_FATAL_FAILURE(expect_each_once(threads, round % 8, std::chrono::microseconds(round % 3 * 40)));
      if (round % 50 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));  // helpers fall asleep
    }
  }
}

/// On the calling thread, once, and with helpers at the same time as jobs.
TEST(ThreadPool, SomethingElseBesideTheJobs) {
  for (int count = 1; count <= 3; ++count) {
    SCOPED_TRACE(count);
    ThreadPool threads(count);
    const auto own_thread = std::this_thread::get_id();
    for (std::uint32_t jobs = 0; jobs < 20; ++jobs) {
      std::atomic<std::uint32_t> done{0};
      int calls = 0;
      const auto beside = [&] {
        EXPECT_EQ(std::this_thread::get_id(), own_thread);
        ++calls;
        while (count > 1 && jobs > 0 && done == 0) std::this_thread::yield();  // a helper begins meanwhile
      };
      threads.run_at_once(
          jobs, [&](std::uint32_t) { ++done; }, beside);
      ASSERT_EQ(done, jobs);
      ASSERT_EQ(calls, 1);
    }
  }
}

/// What short jobs have taught does not keep helpers from a call of long ones.
TEST(ThreadPool, LongJobsReachHelpersAfterShortOnes) {
  ThreadPool threads(2);
  const auto own = std::this_thread::get_id();
  for (int round = 0; round < 1000; ++round) threads.run(2, [](std::uint32_t) {});
  std::atomic<int> done{0};
  std::atomic<bool> other{false};
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  threads.run(64, [&](std::uint32_t) {
    work_for(std::chrono::microseconds(200));
    if (std::this_thread::get_id() != own) other = true;
    // The rest of the jobs waits for the helper.
    while (++done >= 32 && !other && std::chrono::steady_clock::now() < end) std::this_thread::yield();
  });
  EXPECT_TRUE(other);
}

TEST(ThreadPool, LongJobsReachHelpers) {
  ThreadPool threads(2);
  std::atomic<bool> other{false};
  const auto own = std::this_thread::get_id();
  for (int round = 0; round < 1000 && !other; ++round)
    threads.run(4, [&](std::uint32_t) {
      work_for(std::chrono::microseconds(500));
      if (std::this_thread::get_id() != own) other = true;
    });
  EXPECT_TRUE(other);
}

TEST(ThreadPool, EndsAwakeAndAsleep) {
  for (int round = 0; round < 20; ++round) {
    ThreadPool threads(3);
    for (int i = 0; i < 3; ++i) threads.run(4, [](std::uint32_t) { work_for(std::chrono::microseconds(50)); });
    if (round % 2 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

TEST(ThreadPool, TwoCallersAtOnce) {
  ThreadPool threads(2);
  const auto call = [&] {
    for (int round = 0; round < 100; ++round) expect_each_once(threads, 5, std::chrono::microseconds(20));
  };
  std::thread other(call);
  call();
  other.join();
}

/// Counts the threads that take part. Jobs are long enough that all would like to, and the first waits for a second
/// thread, however busy the machine is.
TEST(ThreadPool, NoMoreThreadsThanTheCallAllows) {
  ThreadPool threads(4);
  for (const int most : {1, 2, 3, 4, 0, 9}) {
    SCOPED_TRACE(most);
    std::mutex mutex;
    std::set<std::thread::id> seen;
    std::atomic<std::uint32_t> done{0};
    const auto count = [&] {
      const std::lock_guard lock(mutex);
      seen.insert(std::this_thread::get_id());
      return seen.size();
    };
    const auto job = [&](std::uint32_t) {
      const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
      while (count() < 2 && most != 1 && std::chrono::steady_clock::now() < end) std::this_thread::yield();
      work_for(std::chrono::microseconds(300));
      ++done;
    };
    threads.run_at_once(
        40, job, [] { std::this_thread::sleep_for(std::chrono::milliseconds(2)); }, most);
    EXPECT_EQ(done, 40u);
    EXPECT_LE(seen.size(), std::size_t(most > 0 ? std::min(most, 4) : 4));
    EXPECT_GE(seen.size(), most == 1 ? 1u : 2u);
  }
}

TEST(ThreadPool, JobsMayHaveJobs) {
  ThreadPool threads(3);
  std::atomic<int> done{0};
  threads.run_at_once(5, [&](std::uint32_t) { threads.run(7, [&](std::uint32_t) { ++done; }); });
  EXPECT_EQ(done, 35);
}

TEST(ThreadPool, OfAnApplicationsThreads) {
  ApplicationThreads runner;
  ThreadPool threads(1, &runner);
  EXPECT_EQ(threads.size(), 3);
  for (std::uint32_t round = 0; round < 100; ++round)
    ASSERT_NO_FATAL_FAILURE(expect_each_once(threads, round % 8, std::chrono::microseconds(100)));
  EXPECT_GT(runner.calls, 10);
  const int before = runner.calls;
  std::atomic<int> done{0};
  int beside = 0;
  threads.run_at_once(
      5, [&](std::uint32_t) { threads.run(7, [&](std::uint32_t) { ++done; }); }, [&] { ++beside; });
  EXPECT_EQ(done, 35);
  EXPECT_EQ(beside, 1);
  EXPECT_EQ(runner.calls, before + 1) << "jobs of jobs run on their own thread";
  for (const int most : {1, 2, 3}) {
    std::atomic<int> now{0}, at_once{0}, all{0};
    const auto job = [&](std::uint32_t) {
      const int others = ++now;
      for (int seen = at_once; seen < others && !at_once.compare_exchange_weak(seen, others);) {
      }
      work_for(std::chrono::microseconds(300));
      ++all;
      --now;
    };
    threads.run_at_once(20, job, {}, most);
    EXPECT_EQ(all, 20);
    EXPECT_LE(at_once, most);
  }
}

}  // namespace
}  // namespace sightline::tests::thread_pool_test
