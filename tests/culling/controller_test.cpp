// The controller's contract, call by call. How close it comes to the oracle: tests/apps/controller_trace_test.cpp.
#include "sightline/culling/hybrid/controller.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

namespace sightline::culling::controller_test {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

struct Costs {
  double cpu = 1.0, gpu = 1.0, visible = 1e5;
};

/// Runs frames, GPU samples two frames late; one letter per frame.
class Loop {
 public:
  explicit Loop(const ControllerConfig& config = {}, bool gpu = true) : controller(config) {
    if (gpu) controller.gpu_ready();
  }

  std::string run(std::size_t frames, const Costs& costs) {
    std::string choice;
    for (std::size_t i = 0; i < frames; ++i) choice += step(costs);
    return choice;
  }

  char step(const Costs& costs) {
    const std::uint64_t frame = controller.frames();
    const CullPath path = controller.next();
    if (two_ago_.path == CullPath::kGpu) controller.feed(two_ago_);
    FrameSample sample{.frame = frame, .path = path, .visible = costs.visible};
    sample.cull_ms = sample.frame_ms = path == CullPath::kCpu ? costs.cpu : costs.gpu;
    if (path == CullPath::kCpu) controller.feed(sample);
    two_ago_ = one_ago_;
    one_ago_ = sample;
    return path == CullPath::kCpu ? 'c' : 'g';
  }

  Controller controller;

 private:
  FrameSample one_ago_, two_ago_;
};

std::size_t count(const std::string& choice, char path) {
  return std::size_t(std::count(choice.begin(), choice.end(), path));
}

TEST(Controller, IsSmallAndCopyable) {
  EXPECT_LE(sizeof(Controller), 896u);
  Loop loop;
  loop.run(100, {2.0, 1.0});
  Controller copy = loop.controller;
  for (int i = 0; i < 20; ++i) EXPECT_EQ(copy.next(), loop.controller.next());
}

TEST(Controller, StaysOnTheCpuWithoutAGpu) {
  Loop loop({}, false);
  EXPECT_EQ(loop.run(300, {10.0, 0.1}), std::string(300, 'c'));
  loop.controller.gpu_ready();
  EXPECT_GT(count(loop.run(30, {10.0, 0.1}), 'g'), 10u);
  loop.controller.gpu_lost();
  EXPECT_EQ(loop.run(300, {10.0, 0.1}), std::string(300, 'c'));
  EXPECT_EQ(name_of(loop.controller.state()), "cpu");
  loop.controller.gpu_ready();
  EXPECT_GT(count(loop.run(300, {10.0, 0.1}), 'g'), 250u);
}

TEST(Controller, TakesTheCheaperPathAndKeepsIt) {
  Loop gpu;
  EXPECT_EQ(gpu.run(20, {2.0, 1.0}).substr(8), std::string(12, 'g'));
  EXPECT_LE(500 - count(gpu.run(500, {2.0, 1.0}), 'g'), 3u);  // probes
  EXPECT_EQ(gpu.controller.switches(), 1u);
  Loop cpu;
  EXPECT_LE(count(cpu.run(500, {1.0, 2.0}), 'g'), 3u);
  EXPECT_EQ(cpu.controller.switches(), 0u);
}

TEST(Controller, ReactsToAChangeWithinEightFrames) {
  for (const double step : {1.6, 2.0, 5.0, 50.0}) {
    Loop loop;
    loop.run(300, {1.0, 1.2});
    // But for one probe, whether it was a hiccup.
    EXPECT_GE(count(loop.run(20, {1.2 * step, 1.2}).substr(8), 'g'), 11u) << step;
    EXPECT_GE(count(loop.run(20, {1.2 * step, 1.2 * step * step}).substr(8), 'c'), 11u) << step;
  }
}

/// Where the GPU's path is presumed to be more expensive nothing but probes goes there, however new the view, unless
/// they keep saying that it is cheaper.
TEST(Controller, APresumptionStandsUntilItIsRefuted) {
  ControllerConfig config;
  config.presumed_gpu_excess = 0.1;
  std::mt19937 random(1);
  const auto noise = [&] { return 0.85 + 0.3 * double(random()) * 0x1p-32; };
  for (const double gpu : {1.0, 1.05, 1.2, 2.0}) {
    SCOPED_TRACE(gpu);
    Loop loop(config);
    std::size_t on_gpu = 0;
    for (int i = 0; i < 400; ++i) on_gpu += loop.step({noise(), gpu * noise(), double(64 << (i / 20))}) == 'g';
    EXPECT_LE(on_gpu, 2u);
  }
  config.rendering = false;
  EXPECT_EQ(Loop(config).run(300, {1.0, 0.5}), std::string(300, 'c'));
  config.rendering = true;
  Loop wrong(config);
  EXPECT_GE(count(wrong.run(100, {2.0, 1.0}).substr(40), 'g'), 58u);
  Loop right(config);
  EXPECT_LE(count(right.run(300, {1.0, 1.5}), 'g'), 2u);
}

TEST(Controller, TakesTheOtherPathWhereTheViewSaysSo) {
  Loop loop;
  const Costs few{0.1, 1.0, 1e3}, many{5.0, 1.0, 4e5};
  for (int i = 0; i < 3; ++i) {
    loop.run(60, few);
    loop.run(60, many);
  }
  EXPECT_EQ(loop.run(20, few).substr(4), std::string(16, 'c'));
  EXPECT_EQ(loop.run(20, many).substr(2), std::string(18, 'g'));
}

/// An answer of the GPU's comes late: the view has moved on since.
TEST(Controller, ALateSampleDoesNotTakeTheViewBack) {
  Loop loop;
  const Costs few{0.1, 1.0, 1e3}, many{5.0, 1.0, 4e5};
  for (int i = 0; i < 3; ++i) {
    loop.run(60, few);
    loop.run(60, many);
  }
  loop.run(30, few);
  for (int i = 0; i < 3; ++i) {
    const std::uint64_t frame = loop.controller.frames();
    ASSERT_EQ(loop.controller.next(), CullPath::kCpu);
    loop.controller.feed({.frame = frame, .path = CullPath::kCpu, .frame_ms = few.cpu, .visible = few.visible});
    loop.controller.feed({.frame = frame - 1, .path = CullPath::kGpu, .frame_ms = many.gpu, .visible = many.visible});
  }
}

/// What was learnt octaves away may be wrong: by 0.2 of log(cost) each, but not by more than 1 in all.
TEST(Controller, TriesAPathThatIsOnlyKnownFromFarAway) {
  const auto learnt = [](double log_cost, double visible) {
    Loop loop;
    loop.run(60, {1.0, std::exp(log_cost), visible});
    EXPECT_EQ(loop.controller.switches(), 0u) << log_cost;
    return loop;
  };
  Loop near = learnt(0.7, 16.0);
  EXPECT_EQ(count(near.run(5, {1.0, 0.5, 16.0}), 'g'), 0u);
  Loop far = learnt(0.7, 16.0);
  EXPECT_EQ(far.run(8, {1.0, 0.5, 16.0 * 1024.0}).substr(3), "ggggg");
  Loop farther = learnt(1.6, 1.0);
  farther.run(30, {1.0, std::exp(1.6), 0x1p24});
  EXPECT_EQ(farther.controller.switches(), 0u);
}

/// However often a scene changes: a probe waits for the answer to the one before.
TEST(Controller, ProbesLeaveTimeForAnAnswer) {
  ControllerConfig config;
  config.first_probes = 100;
  Controller controller(config);
  controller.gpu_ready();
  std::vector<std::uint64_t> probes;
  for (std::uint64_t frame = 0; frame < 40; ++frame) {
    controller.scene_changed(1e5);
    const CullPath path = controller.next();
    if (controller.state() == ControllerState::kProbe) probes.push_back(frame);
    if (path == CullPath::kCpu) controller.feed({.frame = frame, .path = path, .frame_ms = 1.0, .visible = 1e4});
  }
  EXPECT_EQ(probes, (std::vector<std::uint64_t>{1, 7, 13, 19, 25, 31, 37}));
}

/// Between paths that cost the same, in noise: the more switches prove vain, the rarer they become.
TEST(Controller, VainSwitchesBecomeRare) {
  std::uint64_t switches = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    std::mt19937 random(seed);
    const auto noise = [&] { return 0.4 + 1.2 * double(random()) * 0x1p-32; };
    Loop loop;
    for (int i = 0; i < 4000; ++i) {
      const double cpu = noise();
      loop.step({cpu, noise()});
    }
    switches += loop.controller.switches();
  }
  EXPECT_LE(switches, 20u * 17u + 10u);  // 30 each where none counts as vain
}

TEST(CostTable, LearnsAsARunningMeanDoes) {
  CostTable table;
  EXPECT_TRUE(table.empty());
  table.learn(9.3, 1.5);
  EXPECT_NEAR(table.predict(9.3), 1.5, 1e-6) << "the first sample wholly";
  EXPECT_FALSE(table.empty());
  for (const double x : {8.0, 8.4, 9.0, 9.3, 9.9, 12.5, 0.0, 60.0})
    for (const double residual : {0.3, -0.2, 0.05}) {
      const double before = table.predict(x), samples = table.samples(x);
      table.learn(x, residual);
      const double share = samples > 0.0 ? std::max(1.0 / (samples + 1.0), 1.0 / CostTable::kMostSamples) : 1.0;
      EXPECT_NEAR(table.predict(x), before + share * residual, 1e-6) << x;
    }
}

TEST(CostTable, FollowsAtALeastRate) {
  CostTable table;
  for (int i = 0; i < 300; ++i) table.learn(10.0, 0.0);  // on a knot
  table.learn(10.0, 1.0);
  EXPECT_NEAR(table.predict(10.0), 1.0 / CostTable::kMostSamples, 1e-6);
}

TEST(CostTable, CountsSamplesWhereTheyWere) {
  CostTable table;
  for (int i = 0; i < 3; ++i) table.learn(10.0, 0.0);  // on a knot; the next one hardly hears of it
  EXPECT_NEAR(table.samples(10.0), 3.0, 1e-6);
  EXPECT_NEAR(table.samples(11.0), 1.5, 0.01);
  EXPECT_NEAR(table.samples(12.0), 0.0, 0.01);
}

TEST(CostTable, StandsForFewerSamplesFarAway) {
  CostTable table;
  for (int i = 0; i < 200; ++i) table.learn(10.5, 0.0);
  EXPECT_NEAR(table.samples(10.5), CostTable::kMostSamples, 1.0);
  EXPECT_EQ(table.distance(10.5), 0.0);
  EXPECT_EQ(table.distance(18.0), 4.0);  // from the knot after the next one
  EXPECT_NEAR(table.samples(18.0), CostTable::kMostSamples / 25.0, 0.1);
  table.shift(10.5, 2.0);
  EXPECT_NEAR(table.predict(10.5), 2.0, 1e-6);
  EXPECT_NEAR(table.samples(10.5), 2.0, 1e-6);
  table.doubt(0.5);
  EXPECT_NEAR(table.samples(10.5), 0.5, 1e-6);
  EXPECT_NEAR(table.predict(10.5), 2.0, 1e-6) << "the curve stays";
}

TEST(Controller, ASpikeIsNoReasonToSwitch) {
  Loop loop;
  loop.run(100, {1.0, 1.5});
  for (int i = 0; i < 20; ++i) {
    loop.run(1, {30.0, 45.0});
    loop.run(17, {1.0, 1.5});
    EXPECT_EQ(loop.controller.switches(), 0u) << i;
  }
}

TEST(Controller, DoesNotFlapInNoise) {
  std::mt19937_64 random(7);
  for (const double gpu : {0.97, 1.0, 1.03, 1.2}) {
    Loop loop;
    for (int i = 0; i < 4000; ++i) {
      std::uniform_real_distribution<double> noise(0.7, 1.3);
      const double c = noise(random), g = noise(random);
      loop.step({c, gpu * g});
    }
    EXPECT_LE(loop.controller.switches(), 60u) << gpu;
    EXPECT_LE(loop.controller.probes(), 20u) << gpu;
  }
}

TEST(Controller, ProbesAreBounded) {
  std::mt19937_64 random(3);
  Loop loop;
  Costs costs;
  for (std::uint64_t i = 1; i <= 5000; ++i) {  // whatever happens
    if (random() % 9 == 0)
      costs = {0.1 + double(random() % 100), 0.1 + double(random() % 100), double(random() % 100000)};
    loop.step(costs);
    EXPECT_LE(loop.controller.probes(), std::max<std::uint64_t>(2, i / 200 + 1)) << i;
  }
}

TEST(Controller, ACpuTooFastForAnyGpuIsNotProbed) {
  ControllerConfig config;
  config.rendering = false;
  Loop loop(config);
  EXPECT_EQ(loop.run(2000, {0.004, 0.001}), std::string(2000, 'c'));
}

TEST(Controller, StaysOnTheCpuWithoutTimers) {
  Loop no_gpu_times;
  EXPECT_LE(count(no_gpu_times.run(2000, {5.0, kNan}), 'g'), 10u);
  Loop no_cpu_times;
  EXPECT_EQ(count(no_cpu_times.run(2000, {kNan, 1.0}), 'g'), 0u);
  // Timers that fail later: back to the CPU, and there it stays but for probes.
  Loop failing;
  EXPECT_GT(count(failing.run(200, {5.0, 1.0}), 'g'), 150u);
  failing.run(30, {5.0, kNan});
  EXPECT_LE(count(failing.run(2000, {5.0, kNan}), 'g'), 12u);
}

TEST(Controller, TakesTheCullTimeWithRenderingOff) {
  for (const bool rendering : {false, true}) {
    ControllerConfig config;
    config.rendering = rendering;
    Controller controller(config);
    controller.gpu_ready();
    std::size_t gpu = 0;
    for (std::uint64_t i = 0; i < 200; ++i) {  // culls faster on the GPU, and yet makes the frame slower
      const CullPath path = controller.next();
      FrameSample sample{.frame = i, .path = path, .cull_ms = 2.0, .frame_ms = 5.0, .visible = 1e4};
      if (path == CullPath::kGpu) sample.cull_ms = 1.0, sample.frame_ms = 6.0;
      controller.feed(sample);
      gpu += path == CullPath::kGpu;
    }
    EXPECT_EQ(gpu > 100, !rendering);
  }
}

TEST(Controller, APauseTeachesNothing) {
  Loop loop;
  loop.run(200, {1.0, 1.5});
  for (int i = 0; i < 5; ++i) {
    loop.controller.paused();
    loop.run(1, {5000.0, 5000.0});
    EXPECT_EQ(count(loop.run(6, {1.0, 1.5}), 'g'), 0u);
  }
}

TEST(Controller, LooksAgainAfterAChangeOfScene) {
  Loop loop;
  loop.run(400, {1.0, 1.5});
  loop.controller.scene_changed(2e5);
  EXPECT_EQ(loop.run(30, {6.0, 1.5}).substr(10), std::string(20, 'g'));
  loop.controller.scene_changed(2e5);
  EXPECT_EQ(loop.run(40, {1.0, 9.0}).substr(10), std::string(30, 'c'));
}

/// Twin of the whole controller where samples are bad: it must behave as if they had not been fed at all.
TEST(Controller, IgnoresStrayAndDamagedSamples) {
  Loop clean, dirty;
  std::mt19937_64 random(11);
  for (int i = 0; i < 3000; ++i) {
    const double c = 0.2 + double(random() % 1000) / 1000.0, g = 0.2 + double(random() % 1000) / 1000.0;
    ASSERT_EQ(clean.step({c, g}), dirty.step({c, g})) << i;
    const std::uint64_t frames = dirty.controller.frames();
    for (const CullPath path : {CullPath::kCpu, CullPath::kGpu}) {
      FrameSample future{.frame = frames + random() % 5, .path = path, .cull_ms = 99.0, .frame_ms = 99.0};
      dirty.controller.feed(future);
      if (frames > 100) {
        FrameSample old{.frame = frames - 65 - random() % 30, .path = path, .cull_ms = 99.0, .frame_ms = 99.0};
        dirty.controller.feed(old);
      }
    }
  }
  for (const double bad : {kNan, -1.0, 0.0, std::numeric_limits<double>::infinity()}) {
    Loop loop;
    loop.run(100, {1.0, 1.5});
    EXPECT_EQ(count(loop.run(50, {bad, bad, bad}), 'g'), 0u) << bad;
    EXPECT_LE(count(loop.run(50, {1.0, 1.5}), 'g'), 1u) << bad;
  }
}

TEST(Controller, IsDeterministic) {
  Loop a, b;
  std::mt19937_64 random(5);
  for (int i = 0; i < 2000; ++i) {
    const Costs costs{double(random() % 100) / 50.0, double(random() % 100) / 50.0, double(random() % 100000)};
    ASSERT_EQ(a.step(costs), b.step(costs));
  }
}

}  // namespace
}  // namespace sightline::culling::controller_test
