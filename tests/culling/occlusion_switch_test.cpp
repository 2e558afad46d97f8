// When the engine tests occlusion, from made-up costs.
#include "sightline/culling/hybrid/internal/occlusion_switch.h"

#include <array>
#include <cmath>
#include <functional>
#include <random>

#include <gtest/gtest.h>

namespace sightline::culling::occlusion_switch_test {
namespace {

/// What a part takes of what the frame would without the test.
constexpr double kPart = OcclusionSwitch::kTriedPart;

/// Frames of both ways with noise, in views of which some take ten times as long as others; what they cost together.
struct Flown {
  double chosen = 0.0, best = 0.0;
  double worst = 0.0;  // frame, of what it would best have cost
  int frames_on = 0;
};
template <class Cost>
Flown fly(OcclusionSwitch& choice, int frames, const Cost& cost, const std::function<double(int)>& area = {}) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> noise(0.95, 1.05), view(10.0, 100.0);
  Flown flown;
  for (int i = 0; i < frames; ++i) {
    const OcclusionMode mode = choice.use(area ? area(i) : 50.0);
    const bool on = mode != OcclusionMode::kOff, measured = mode == OcclusionMode::kOnBesidePart;
    const double of_view = view(random), ms = cost(i, on) * of_view * noise(random);
    const double part_ms = measured ? kPart * cost(i, false) * of_view * noise(random) : 0.0;
    if (measured) choice.measured(ms, part_ms);
    const double best = std::min(cost(i, true), cost(i, false)) * of_view;
    flown.chosen += ms + part_ms;
    flown.best += best;
    flown.worst = std::max(flown.worst, (ms + part_ms) / best);
    flown.frames_on += on;
  }
  return flown;
}

TEST(OcclusionSwitch, KeepsWhatPays) {
  for (const double ratio : {1.1, 1.5, 3.0, 20.0}) {
    OcclusionSwitch choice;
    const auto cost = [&](int, bool on) { return on ? 1.0 : ratio; };
    const Flown first = fly(choice, 60, cost), later = fly(choice, 2000, cost);
    EXPECT_EQ(first.frames_on + later.frames_on, 2060) << ratio;
    EXPECT_LT(first.chosen, (1.01 + 4 * kPart * ratio / 60) * first.best) << ratio;
    EXPECT_LT(later.chosen, 1.03 * later.best) << ratio;
    EXPECT_LT(later.worst, 1.1 * (1.0 + kPart * ratio)) << ratio;
  }
}

TEST(OcclusionSwitch, LeavesWhatDoesNotPay) {
  for (const double ratio : {1.1, 1.5, 2.0}) {
    OcclusionSwitch choice;
    const auto cost = [&](int, bool on) { return on ? ratio : 1.0; };
    const Flown first = fly(choice, 60, cost), later = fly(choice, 2000, cost);
    EXPECT_LT(first.frames_on, 15) << ratio;
    EXPECT_LT(first.chosen, 1.1 * first.best * (1.0 + 0.1 * (ratio - 1.0))) << ratio;
    EXPECT_LT(later.chosen, 1.05 * later.best) << ratio;
  }
}

TEST(OcclusionSwitch, FollowsTheScene) {
  OcclusionSwitch choice;
  const auto cost = [](int i, bool on) { return (i / 3000 % 2 == 0) == on ? 1.0 : 2.5; };
  const Flown flown = fly(choice, 12000, cost);
  EXPECT_LT(flown.chosen, 1.15 * flown.best);
}

/// A flight around a plant and into it and out again.
TEST(OcclusionSwitch, KnowsViewsOfTheSameSizesAgain) {
  OcclusionSwitch choice;
  const auto inside = [](int i) { return i / 40 % 2 != 0; };
  const auto cost = [&](int i, bool on) { return inside(i) == on ? 1.0 : 1.4; };
  const auto area = [&](int i) { return inside(i) ? 200.0 : 10.0; };
  (void)fly(choice, 400, cost, area);
  const Flown flown = fly(choice, 2000, cost, area);
  EXPECT_LT(flown.chosen, 1.05 * flown.best);
}

/// Each view of another class than the one before: what one has found serves all, and they do not all measure.
TEST(OcclusionSwitch, ClassesBeginWithWhatOneHasFound) {
  for (const double of_off : {3.0, 1.0 / 3.0}) {
    OcclusionSwitch choice;
    const auto cost = [&](int, bool on) { return on ? 1.0 : of_off; };
    const Flown flown = fly(choice, 60, cost, [](int i) { return std::pow(4.0, i < 12 ? 3.0 : i % 6) - 0.5; });
    EXPECT_LT(flown.chosen, 1.25 * flown.best) << of_off;
  }
}

TEST(OcclusionSwitch, TakesAnySize) {
  OcclusionSwitch choice;
  for (const double area : {-1.0, 0.0, 1e-300, 1.0, 3.9, 1e4, 1e300, HUGE_VAL, double(NAN)})
    EXPECT_NE(choice.use(area), OcclusionMode::kOff);
}

TEST(OcclusionSwitch, EqualCostsAreNotMeasuredOften) {
  OcclusionSwitch choice;
  const Flown flown = fly(choice, 5000, [](int, bool) { return 1.0; });
  EXPECT_LT(flown.chosen, 1.01 * flown.best);
}

TEST(OcclusionSwitch, FramesWithoutACostTellNothing) {
  OcclusionSwitch choice;
  for (int i = 0; i < 100; ++i) {
    EXPECT_NE(choice.use(0.0), OcclusionMode::kOff);
    choice.measured(0.0, 1.0);
    choice.measured(1.0, 0.0);
    choice.measured(-1.0, -1.0);
  }
}

/// Frames of each way that a trial asks for, on a device where an item takes 1 us and a test so many milliseconds.
std::array<int, 4> try_out(OcclusionTrial& trial, int frames, double items, double test_ms) {
  std::array<int, 4> count{};
  for (int i = 0; i < frames; ++i) {
    const OcclusionTrial::Frame frame = trial.next(items);
    ++count[std::size_t(frame)];
    if (frame == OcclusionTrial::Frame::kTimedPlain) trial.plain_took(1e-3 * items);
    if (frame == OcclusionTrial::Frame::kTimedTest) trial.test_took(test_ms);
  }
  return count;
}

/// A test that takes far longer than drawing costs one frame in hundreds, until there is enough to draw; one that may
/// pay is left to the switch at once.
TEST(OcclusionTrial, TriesWhereThereIsSomethingToGain) {
  OcclusionTrial trial;
  const auto [plain, timed_plain, timed_test, switched] = try_out(trial, 2000, 20'000, 100.0);
  EXPECT_EQ(switched, 0);
  EXPECT_LE(timed_plain, 4);
  EXPECT_LE(timed_test, 4);
  EXPECT_GE(plain, 1990);
  EXPECT_EQ(try_out(trial, 10, 2'000'000, 100.0)[3], 10);
  OcclusionTrial other;
  EXPECT_GE(try_out(other, 100, 20'000, 30.0)[3], 95);
}

}  // namespace
}  // namespace sightline::culling::occlusion_switch_test
