// Views shared out among threads: every job once, and the sets of one view at a time.
#include "sightline/culling/frustum/cull_threads.h"

#include <atomic>
#include <chrono>
#include <memory>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "scenes.h"

namespace sightline::tests::cull_threads_test {
namespace {

using culling::CullThreads;

void work_for(std::chrono::microseconds time) {
  const auto end = std::chrono::steady_clock::now() + time;
  while (std::chrono::steady_clock::now() < end) {
  }
}

/// Counts how often each job runs. Long jobs are worth a helper, short ones are not.
void expect_each_once(CullThreads& threads, std::uint32_t jobs, std::chrono::microseconds time) {
  const std::unique_ptr<std::atomic<int>[]> runs(new std::atomic<int>[jobs + 1]);
  for (std::uint32_t i = 0; i <= jobs; ++i) runs[i] = 0;
  threads.run(jobs, [&](std::uint32_t i) {
    work_for(time);
    ++runs[i];
  });
  for (std::uint32_t i = 0; i < jobs; ++i) ASSERT_EQ(runs[i], 1) << "job " << i << " of " << jobs;
  ASSERT_EQ(runs[jobs], 0);
}

TEST(CullThreads, EveryJobRunsOnce) {
  for (int count = 1; count <= 4; ++count) {
    SCOPED_TRACE(count);
    CullThreads threads(count);
    EXPECT_EQ(threads.count(), count);
    for (std::uint32_t round = 0; round < 300; ++round) {
      ASSERT_NO_FATAL_FAILURE(expect_each_once(threads, round % 8, std::chrono::microseconds(round % 3 * 40)));
      if (round % 50 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));  // helpers fall asleep
    }
  }
}

/// On the calling thread, once, and with helpers at the same time as jobs.
TEST(CullThreads, SomethingElseBesideTheJobs) {
  for (int count = 1; count <= 3; ++count) {
    SCOPED_TRACE(count);
    CullThreads threads(count);
    const auto own_thread = std::this_thread::get_id();
    for (std::uint32_t jobs = 0; jobs < 20; ++jobs) {
      std::atomic<std::uint32_t> done{0};
      int calls = 0;
      const auto beside = [&] {
        EXPECT_EQ(std::this_thread::get_id(), own_thread);
        ++calls;
        while (count > 1 && jobs > 0 && done == 0) std::this_thread::yield();  // a helper begins meanwhile
      };
      threads.run(
          jobs, [&](std::uint32_t) { ++done; }, beside);
      ASSERT_EQ(done, jobs);
      ASSERT_EQ(calls, 1);
    }
  }
}

TEST(CullThreads, LongJobsReachHelpers) {
  CullThreads threads(2);
  std::atomic<bool> other{false};
  const auto own = std::this_thread::get_id();
  for (int round = 0; round < 1000 && !other; ++round)
    threads.run(4, [&](std::uint32_t) {
      work_for(std::chrono::microseconds(500));
      if (std::this_thread::get_id() != own) other = true;
    });
  EXPECT_TRUE(other);
}

TEST(CullThreads, EndsAwakeAndAsleep) {
  for (int round = 0; round < 20; ++round) {
    CullThreads threads(3);
    for (int i = 0; i < 3; ++i) threads.run(4, [](std::uint32_t) { work_for(std::chrono::microseconds(50)); });
    if (round % 2 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

TEST(CullThreads, TwoCallersAtOnce) {
  CullThreads threads(2);
  const auto call = [&] {
    for (int round = 0; round < 100; ++round) expect_each_once(threads, 5, std::chrono::microseconds(20));
  };
  std::thread other(call);
  call();
  other.join();
}

TEST(CullThreads, SeveralViewsAreTheViewsOneByOne) {
  constexpr std::uint64_t kSeed = 7;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  Random random(kSeed);
  const Scene scene(random_boxes(random, 30'000, 50.0), core::dvec3(0.0));
  CullThreads threads(3);
  for (int round = 0; round < 40; ++round) {
    std::vector<core::View> views;
    for (int i = whole(random, 0, 8); i > 0; --i) views.push_back(random_view(random, core::dvec3(0.0), 50.0));
    std::vector<core::VisibleSet> sets(views.size());
    for (CullThreads* with : {static_cast<CullThreads*>(nullptr), &threads}) {
      scene.culler->cull(views, sets, with);
      for (std::size_t i = 0; i < views.size(); ++i) {
        core::VisibleSet alone;
        scene.culler->cull(views[i], alone);
        ASSERT_EQ(sets[i].ranges, alone.ranges);
        ASSERT_EQ(sets[i].single_slots, alone.single_slots);
      }
    }
  }
}

}  // namespace
}  // namespace sightline::tests::cull_threads_test
