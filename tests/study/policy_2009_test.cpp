// The controller of the 2009 dissertation, frame by frame, and its traces beside those of the library's controller.
#include "sightline/apps/study/policy_2009.h"

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/apps/bench/synthetic_traces.h"
#include "sightline/tests/support/places.h"

namespace sightline::study::policy_2009_test {
namespace {

/// The choice of further frames in which the CPU culls for `ms`; one letter a frame.
std::string run(Policy2009& policy, std::size_t frames, double ms) {
  std::string choice;
  for (std::size_t i = 0; i < frames; ++i) {
    const culling::CullPath path = policy.next();
    choice += path == culling::CullPath::kCpu ? 'c' : 'g';
    policy.feed({.path = path, .cull_ms = path == culling::CullPath::kCpu ? ms : 9.0});
  }
  return choice;
}

TEST(Policy2009, FollowsFigure64) {
  using State = Policy2009::State;
  Policy2009 policy;
  const double slow = 0.31, fast = 0.29;
  EXPECT_EQ(run(policy, 50, fast), std::string(50, 'c'));
  EXPECT_EQ(run(policy, 4, slow), "cccc");
  EXPECT_EQ(policy.state(), State::kCpuToGpu);
  EXPECT_EQ(run(policy, 1, fast), "c");  // not five in a row
  EXPECT_EQ(policy.state(), State::kCpu);
  EXPECT_EQ(run(policy, 5, slow), "ccccc");
  EXPECT_EQ(policy.state(), State::kGpu);
  EXPECT_EQ(run(policy, 500, slow), std::string(500, 'g'));
  EXPECT_EQ(run(policy, 2, slow), "cc");  // two probe frames, still slow: twice as long
  EXPECT_EQ(run(policy, 1000, slow), std::string(1000, 'g'));
  EXPECT_EQ(run(policy, 1, slow), "c");
  EXPECT_EQ(policy.state(), State::kGpuToCpu);
  EXPECT_EQ(run(policy, 100, fast), std::string(100, 'c'));
  EXPECT_EQ(policy.switches(), 2u);
  EXPECT_EQ(policy.probes(), 4u);
  EXPECT_EQ(run(policy, 506, slow).substr(5), std::string(500, 'g') + "c") << "m starts over";
}

TEST(Policy2009, TheThresholdIsStrict) {
  for (const double fast : {0.25, std::nan("")}) {
    Policy2009 policy({.slow_ms = 0.25});
    EXPECT_EQ(run(policy, 20, fast), std::string(20, 'c'));
  }
  Policy2009 policy({.slow_ms = 0.25});
  EXPECT_EQ(run(policy, 7, std::nextafter(0.25, 1.0)), "cccccgg");
}

TEST(Policy2009, DoublingEnds) {
  Policy2009 policy({.gpu_frames = 3, .most_gpu_frames = 6});
  EXPECT_EQ(run(policy, 5 + 3 + 2 + 6 + 2 + 6 + 2, 1.0), "cccccgggccggggggccggggggcc");
}

/// A trace's choice and sums, from the state machine alone.
TEST(Policy2009, RunsOverATrace) {
  const std::vector<apps::TraceFrame> trace(600, {2.0, 2.0, 1.0, 1.0, 1000.0});
  for (const bool rendering : {false, true}) {
    const apps::TraceResult result = run_2009(trace, rendering);
    EXPECT_EQ(result.choice, std::string(5, 'c') + std::string(500, 'g') + "cc" + std::string(93, 'g'));
    EXPECT_EQ(result.chosen_ms, 607.0);
    EXPECT_EQ(result.oracle_ms, 600.0);
    EXPECT_EQ(result.probes, 2u);
    EXPECT_EQ(result.switches, 1u);
  }
}

/// The library's controller chooses better.
TEST(Policy2009, IsFartherFromTheOracleOnRecordedTraces) {
  double ours = 0.0, theirs = 0.0;
  for (const char* name : {"plant_713k.csv", "plant_5m.csv"}) {
    const auto trace =
        apps::read_controller_trace(tests::in_checkout(std::string("apps/bench/traces/") + name).string());
    ASSERT_TRUE(trace) << trace.error().message;
    for (const bool rendering : {false, true}) {
      const auto r = apps::run_controller(*trace, rendering);
      ours += r.chosen_ms / r.oracle_ms / 4;
      theirs += run_2009(*trace, rendering).chosen_ms / r.oracle_ms / 4;
    }
  }
  EXPECT_GE(theirs, ours);
}

}  // namespace
}  // namespace sightline::study::policy_2009_test
