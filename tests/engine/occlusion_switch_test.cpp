// When the engine tests occlusion, from made-up costs.
#include "sightline/engine/internal/occlusion_switch.h"

#include <cmath>
#include <functional>
#include <random>

#include <gtest/gtest.h>

namespace sightline::engine::occlusion_switch_test {
namespace {

/// Frames of both ways with noise; what they cost together.
struct Flown {
  double chosen = 0.0, best = 0.0;
  double worst = 0.0;  // frame, of what it would best have cost
  int frames_on = 0;
};
template <class Cost>
Flown fly(OcclusionSwitch& choice, int frames, const Cost& cost, const std::function<double(int)>& area = {}) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> noise(0.95, 1.05), items(2e4, 2e5);
  Flown flown;
  for (int i = 0; i < frames; ++i) {
    const OcclusionWay way = choice.use(area ? area(i) : 0.0);
    const bool on = way != OcclusionWay::kOff;
    const double part = way == OcclusionWay::kOnBesidePart ? OcclusionSwitch::kTriedPart : 0.0;
    const double n = items(random), ms = (cost(i, on) + part * cost(i, false)) * n * noise(random);
    const double best = std::min(cost(i, true), cost(i, false)) * n;
    flown.chosen += ms;
    flown.best += best;
    flown.worst = std::max(flown.worst, ms / best);
    flown.frames_on += on;
    choice.took(ms, n);
  }
  return flown;
}

TEST(OcclusionSwitch, KeepsWhatPays) {
  OcclusionSwitch choice;
  const Flown flown = fly(choice, 2000, [](int, bool on) { return on ? 1e-4 : 3e-4; });
  EXPECT_GT(flown.frames_on, 1950);
  EXPECT_LT(flown.chosen, 1.05 * flown.best);
}

TEST(OcclusionSwitch, LeavesWhatDoesNotPay) {
  for (const double dearer : {1.1, 1.5, 2.0}) {
    OcclusionSwitch choice;
    const Flown first = fly(choice, 60, [&](int, bool on) { return on ? dearer * 1e-4 : 1e-4; });
    EXPECT_LT(first.frames_on, 30) << dearer;
    const Flown later = fly(choice, 2000, [&](int, bool on) { return on ? dearer * 1e-4 : 1e-4; });
    EXPECT_LT(later.chosen, 1.05 * later.best) << dearer;
  }
}

TEST(OcclusionSwitch, FollowsTheScene) {
  OcclusionSwitch choice;
  const auto cost = [](int i, bool on) { return (i / 3000 % 2 == 0) == on ? 1e-4 : 2.5e-4; };
  const Flown flown = fly(choice, 12000, cost);
  EXPECT_LT(flown.chosen, 1.15 * flown.best);
}

/// A flight around a plant and into it and out again.
TEST(OcclusionSwitch, KnowsViewsOfTheSameSizesAgain) {
  OcclusionSwitch choice;
  const auto inside = [](int i) { return i / 40 % 2 != 0; };
  const auto cost = [&](int i, bool on) { return inside(i) == on ? 1e-4 : 1.5e-4; };
  const auto area = [&](int i) { return inside(i) ? 200.0 : 10.0; };
  (void)fly(choice, 400, cost, area);
  const Flown flown = fly(choice, 2000, cost, area);
  EXPECT_LT(flown.chosen, 1.05 * flown.best);
}

TEST(OcclusionSwitch, TakesAnySize) {
  OcclusionSwitch choice;
  for (const double area : {-1.0, 0.0, 1e-300, 1.0, 3.9, 1e4, 1e300, HUGE_VAL, double(NAN)}) {
    EXPECT_EQ(choice.use(area), OcclusionWay::kOn);
    choice.took(1.0, 1e5);
  }
}

/// Frames without the test are many times as dear: no frame is much dearer than it need be.
TEST(OcclusionSwitch, TriesAPartOfWhatIsDear) {
  for (const double dearer : {3.0, 6.0, 20.0}) {
    OcclusionSwitch choice;
    const Flown flown = fly(
        choice, 3000, [&](int, bool on) { return on ? 1e-4 : dearer * 1e-4; }, [](int) { return 50.0; });
    EXPECT_EQ(flown.frames_on, 3000) << dearer;
    EXPECT_LT(flown.worst, 1.1 * (1.0 + dearer / 8.0)) << dearer;
  }
  OcclusionSwitch choice;
  const Flown flown = fly(
      choice, 300, [&](int, bool on) { return on ? 1e-4 : 0.8e-4; }, [](int) { return 50.0; });
  EXPECT_LT(flown.frames_on, 60) << "what is cheaper is found";
}

TEST(OcclusionSwitch, EqualCostsDoNotToggle) {
  OcclusionSwitch choice;
  int switches = 0;
  OcclusionWay before = choice.use(0.0);
  for (int i = 0; i < 5000; ++i) {
    choice.took(16.6, 1e5);
    switches += choice.use(0.0) != before;
    before = choice.use(0.0);
  }
  EXPECT_LT(switches, 2 * (6 + 5000 / 512)) << "trials alone";
}

TEST(OcclusionSwitch, FramesWithoutACostTellNothing) {
  OcclusionSwitch choice;
  for (int i = 0; i < 100; ++i) {
    choice.took(0.0, 1e5);
    choice.took(-1.0, 1e5);
    choice.took(5.0, 0.0);
    EXPECT_EQ(choice.use(0.0), OcclusionWay::kOn);
  }
}

}  // namespace
}  // namespace sightline::engine::occlusion_switch_test
