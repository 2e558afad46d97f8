// What items are drawn in which order within a time, without drawing.
#include "sightline/culling/occlusion/internal/budget_passes.h"

#include <cmath>
#include <set>

#include <gtest/gtest.h>

namespace sightline::culling::budget_passes_test {
namespace {

using core::View;

struct Site {
  Site() {
    bounds.resize(3000);
    for (std::size_t i = 0; i < bounds.size(); ++i) {  // squares on a wall, of 1 to 1,000 areas
      const float size = 0.01f * std::sqrt(float(i % 1000 + 1));
      const float x = float(i % 60) - 30.0f, z = float(i / 60) - 25.0f;
      bounds.set(i, {{x, 100.0f, z}, {x + size, 100.0f, z + size}});
    }
    all.ranges = {{0, 3000}};
  }
  core::ItemBounds bounds;
  core::VisibleSet all;
  View view = *View::perspective({{0, 0, 0}, {0, 1, 0}, {0, 0, 1}}, 1.0, 1.0, 0.1);
  culling::ContributionTest measure{view, core::dvec3(0.0), 1000, 1000};
};

/// Depths in front of everything, but for the left half of the image.
void hide_right_half(culling::DepthPyramid& pyramid) {
  std::vector<float> distances(1000 * 1000, 50.0f);
  for (std::size_t y = 0; y < 1000; ++y)
    for (std::size_t x = 0; x < 500; ++x) distances[1000 * y + x] = std::numeric_limits<float>::infinity();
  pyramid.build(distances, 1000, 1000);
}

TEST(BudgetPasses, DrawsTheLargestFirstAndEachOnce) {
  Site site;
  BudgetPasses passes;
  passes.begin(site.measure, site.bounds, site.all, {});
  std::set<core::Slot> drawn;
  float least = std::numeric_limits<float>::infinity();
  int count = 0;
  while (passes.next(nullptr, site.bounds, 2.0)) {
    float largest = 0.0f, smallest = std::numeric_limits<float>::infinity();
    ASSERT_TRUE(std::is_sorted(passes.pass().single_slots.begin(), passes.pass().single_slots.end()));
    for (const core::Slot s : passes.pass().single_slots) {
      ASSERT_TRUE(drawn.insert(s).second);
      const float area = site.measure.area(site.bounds.box(s));
      largest = std::max(largest, area), smallest = std::min(smallest, area);
    }
    ASSERT_LE(largest, 2.0f * least) << "classes of twice the area";
    least = smallest;
    ASSERT_EQ(passes.drawn(), drawn.size());
    ASSERT_EQ(passes.pending(), 3000 - drawn.size());
    passes.took(2.0);
    ++count;
  }
  EXPECT_EQ(drawn.size(), 3000u);
  EXPECT_TRUE(passes.complete());
  EXPECT_GT(count, 2);
}

/// Passes come to fit the time that they are given, whatever items cost.
TEST(BudgetPasses, LearnsWhatItemsCost) {
  Site site;
  for (const double per_item : {2e-4, 5e-3, 0.1}) {
    BudgetPasses passes;
    double took = 0.0;
    for (int frame = 0; frame < 40; ++frame) {
      passes.begin(site.measure, site.bounds, site.all, {});
      ASSERT_TRUE(passes.next(nullptr, site.bounds, 10.0));
      took = per_item * double(passes.pass().single_slots.size());
      passes.took(took);
    }
    if (per_item * 3000 > 10.0)
      EXPECT_NEAR(took, 10.0, 1.5) << per_item;
    else
      EXPECT_TRUE(passes.complete());
  }
}

/// A device that is a thousand times as fast as presumed is known after a few small passes of the largest items: the
/// other sizes follow.
TEST(BudgetPasses, OtherSizesFollowWhatAPassTook) {
  Site site;
  BudgetPasses passes;
  passes.begin(site.measure, site.bounds, site.all, {});
  const double presumed = passes.most_pending_ms();
  for (int pass = 0; pass < 10; ++pass) {
    ASSERT_TRUE(passes.next(nullptr, site.bounds, 0.0));
    passes.took(1e-5 * double(passes.pass().single_slots.size()));
  }
  ASSERT_GT(passes.pending(), 2000u);
  EXPECT_LT(passes.most_pending_ms(), presumed / 50.0);
}

TEST(BudgetPasses, OccludedItemsCostNothingAndOthersComeFirst) {
  Site site;
  culling::DepthPyramid pyramid;
  hide_right_half(pyramid);
  const culling::OcclusionTest test(site.view, core::dvec3(0.0), 1000, 1000, pyramid);
  core::VisibleSet open;
  test.filter(site.bounds, site.all, open);
  BudgetPasses passes;
  passes.begin(site.measure, site.bounds, site.all, {});
  while (passes.next(&test, site.bounds, 1.0)) passes.took(1.0);
  EXPECT_EQ(passes.drawn(), open.count());
  EXPECT_EQ(passes.pending_ms(), 0.0);
  passes.remember(test, site.bounds);
  passes.begin(site.measure, site.bounds, site.all, {});
  pyramid.clear(1000, 1000);
  ASSERT_TRUE(passes.next(&test, site.bounds, 0.0));  // the least pass there is
  const auto slots = open.sorted_slots();
  const std::set<core::Slot> were_open(slots.begin(), slots.end());
  for (const core::Slot s : passes.pass().single_slots) EXPECT_TRUE(were_open.count(s));
}

/// Where an image is known, what it shows is drawn first, untested; others are drawn if they are open.
TEST(BudgetPasses, WhatAnImageShowsComesFirst) {
  Site site;
  core::ThreadPool threads(2);
  culling::DepthPyramid pyramid;
  hide_right_half(pyramid);
  const culling::OcclusionTest test(site.view, core::dvec3(0.0), 1000, 1000, pyramid);
  core::VisibleSet some;
  some.ranges = {{10, 990}, {1500, 1234}};
  some.single_slots = {1200, 1203, 2999};
  core::VisibleSet open;
  test.filter(site.bounds, some, open);
  core::VisibleSet shown, rest;
  for (const core::SlotRange& range : some.ranges)
    for (core::Slot slot = range.first; slot < range.first + range.count; ++slot)
      append_range(slot, slot + 1, (slot % 7 == 0 ? shown : rest).ranges);
  for (const core::Slot slot : some.single_slots) (slot % 7 == 0 ? shown : rest).single_slots.push_back(slot);
  for (const culling::OcclusionTest* tests : {&test, static_cast<const culling::OcclusionTest*>(nullptr)}) {
    std::set<core::Slot> first, others;
    some.for_each_slot([&](core::Slot slot) { (slot % 7 == 0 ? first : others).insert(slot); });
    const std::size_t candidates = first.size() + others.size();
    if (tests) {
      others.clear();
      open.for_each_slot([&](core::Slot slot) {
        if (slot % 7 != 0) others.insert(slot);
      });
      ASSERT_GT(others.size(), 100u);
    }
    BudgetPasses passes;
    passes.begin_shown(site.measure, site.bounds, shown, rest, {});
    EXPECT_EQ(passes.pending(), candidates);
    std::size_t drawn = 0;
    while (!passes.complete()) {
      if (passes.tests_others()) {
        EXPECT_TRUE(first.empty());
        passes.test_others(site.measure, tests, site.bounds, nullptr, threads, 0.0);
      }
      if (!passes.next(nullptr, site.bounds, 1.0)) continue;
      drawn += passes.pass().single_slots.size();
      for (const core::Slot slot : passes.pass().single_slots) {
        ASSERT_EQ((first.empty() ? others : first).erase(slot), 1u) << slot;
        std::vector<std::uint64_t> bits;
        passes.looked_at(3000, bits);
        ASSERT_TRUE(contains(bits, slot));
      }
      passes.took(1.0);
      std::vector<std::uint64_t> bits;
      passes.looked_at(3000, bits);
      for (const core::Slot slot : first) ASSERT_FALSE(contains(bits, slot)) << "neither drawn nor hidden";
    }
    EXPECT_TRUE(others.empty()) << others.size();
    EXPECT_EQ(passes.drawn(), drawn);
    EXPECT_EQ(passes.pending(), 0u);
    std::vector<std::uint64_t> bits;
    passes.looked_at(3000, bits);
    some.for_each_slot([&](core::Slot slot) { EXPECT_TRUE(contains(bits, slot)); });
  }
}

/// Splats and reports are for items that wait, and no line is one of them.
TEST(BudgetPasses, LinesNeverWait) {
  Site site;
  std::vector<std::uint64_t> lines{1u << 5}, bits;
  BudgetPasses passes;
  passes.begin(site.measure, site.bounds, site.all, lines);
  passes.looked_at(3000, bits);
  for (core::Slot slot = 0; slot < 3000; ++slot) EXPECT_EQ(contains(bits, slot), slot == 5);
}

TEST(BudgetPasses, OtherCandidatesAreTestedInSets) {
  constexpr std::uint32_t kMany = 600'000;
  Site site;
  site.bounds.resize(kMany);
  for (std::size_t i = 0; i < kMany; ++i) site.bounds.set(i, {{0, 100, 0}, {1, 101, 1}});
  core::VisibleSet none, many;
  many.ranges = {{0, kMany}};
  core::ThreadPool threads(1);
  BudgetPasses passes;
  passes.begin_shown(site.measure, site.bounds, none, many, {});
  std::size_t drawn = 0, sets = 0;
  while (!passes.complete()) {
    ASSERT_EQ(passes.pending() + drawn, kMany);
    if (passes.tests_others()) passes.test_others(site.measure, nullptr, site.bounds, nullptr, threads, 0.0), ++sets;
    ASSERT_TRUE(passes.next(nullptr, site.bounds, 1e9));
    passes.took(0.0);
    drawn += passes.pass().single_slots.size();
  }
  EXPECT_EQ(drawn, kMany);
  EXPECT_EQ(sets, 3u);
}

/// What is pending is expected to be hidden as much as what was looked at.
TEST(BudgetPasses, ForeseeWhatIsPending) {
  Site site;
  culling::DepthPyramid pyramid;
  std::vector<float> distances(1000 * 1000, std::numeric_limits<float>::infinity());
  for (std::size_t y = 0; y < 500; ++y) std::fill_n(distances.begin() + std::ptrdiff_t(1000 * y), 1000, 50.0f);
  pyramid.build(distances, 1000, 1000);
  const culling::OcclusionTest test(site.view, core::dvec3(0.0), 1000, 1000, pyramid);
  BudgetPasses passes;
  passes.begin(site.measure, site.bounds, site.all, {});
  const double all = passes.pending_ms(), item = all / 3000.0;  // at first all classes cost nearly the same
  ASSERT_TRUE(passes.next(&test, site.bounds, 0.25 * all));
  const double looked_at = double(3000 - passes.pending()), drawn = double(passes.drawn());
  ASSERT_GT(passes.pending(), 300u);
  ASSERT_LT(drawn, 0.7 * looked_at);
  EXPECT_NEAR(passes.pending_ms(), item * double(passes.pending()) * drawn / looked_at, 0.05 * all);
}

}  // namespace
}  // namespace sightline::culling::budget_passes_test
