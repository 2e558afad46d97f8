// Projected areas against the convex hull of the corners in double, and what they leave out.
#include "sightline/culling/contribution.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "exact_samples.h"

namespace sightline::tests {
namespace {

using culling::ContributionTest;

/// Of the convex hull (A. Andrew, "Another efficient algorithm for convex hulls in two dimensions", 1979).
double hull_area(std::vector<core::dvec2> points) {
  std::sort(points.begin(), points.end(),
            [](const auto& a, const auto& b) { return a.x < b.x || (a.x == b.x && a.y < b.y); });
  const auto turn = [](const core::dvec2& a, const core::dvec2& b, const core::dvec2& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
  };
  double area = 0.0;
  for (int side = 0; side < 2; ++side) {
    std::vector<core::dvec2> chain;
    for (const core::dvec2& p : points) {
      while (chain.size() > 1 && turn(chain[chain.size() - 2], chain.back(), p) <= 0.0) chain.pop_back();
      chain.push_back(p);
    }
    for (std::size_t i = 1; i < chain.size(); ++i)
      area += 0.5 * (chain[i - 1].x * chain[i].y - chain[i].x * chain[i - 1].y);
    std::reverse(points.begin(), points.end());
  }
  return area;
}

/// The corners in pixels; none when one is behind the eye.
std::vector<core::dvec2> corners_of(const View& view, const core::dvec3& origin, const Aabb& box, int width,
                                    int height) {
  std::vector<core::dvec2> corners;
  for (int i = 0; i < 8; ++i) {
    const core::dvec3 p(i & 1 ? box.max.x : box.min.x, i & 2 ? box.max.y : box.min.y, i & 4 ? box.max.z : box.min.z);
    const core::dvec4 clip = view.clip_from_world() * core::dvec4(p + origin, 1.0);
    if (clip.w <= 0.0) return {};
    corners.emplace_back(0.5 * width * clip.x / clip.w, 0.5 * height * clip.y / clip.w);
  }
  return corners;
}

TEST(ContributionTest, AreasAreThoseOfTheOutline) {
  int measured = 0, behind = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const auto [half, origin, view] = RandomSite(random);
    const int width = whole(random, 1, 3000), height = whole(random, 1, 2000);
    const ContributionTest test(view, origin, width, height);
    for (int i = 0; i < 50; ++i) {
      const Aabb box = random_box(random, half);
      const auto corners = corners_of(view, origin, box, width, height);
      const float area = test.area(box);
      if (corners.empty()) {
        ASSERT_EQ(area, std::numeric_limits<float>::infinity());
        ++behind;
        continue;
      }
      double reach = 0.0;
      for (const auto& c : corners) reach = std::max({reach, std::abs(c.x), std::abs(c.y)});
      if (std::isinf(area) || reach > 1e4) continue;  // reaches too near to the eye
      const double exact = hull_area(corners);
      ASSERT_NEAR(area, exact, 1e-3 * exact + 1e-3) << "box " << i;
      ++measured;
    }
  }
  EXPECT_GT(measured, 2000);
  EXPECT_GT(behind, 500);
  const View view = *View::perspective({{0, 0, 0}, {0, 1, 0}, {0, 0, 1}}, 1.0, 1.0, 0.1);
  EXPECT_EQ(ContributionTest(view, core::dvec3(0.0), 10, 10).area({}), 0.0f);
}

TEST(ContributionTest, WhatIsInsideIsSmaller) {
  Random random(7);
  const View view = *View::perspective({{0, 0, 0}, {0, 1, 0}, {0, 0, 1}}, 1.0, 1.0, 0.1);
  const ContributionTest test(view, core::dvec3(0.0), 500, 500);
  for (int i = 0; i < 2000; ++i) {
    Aabb outer = random_box(random, 10.0);
    outer.min.y += 40.0f, outer.max.y += 40.0f;
    const core::vec3 size = outer.max - outer.min;
    const Aabb inner{outer.min + size * float(uniform(random, 0.0, 0.5)),
                     outer.max - size * float(uniform(random, 0.0, 0.5))};
    ASSERT_LE(test.area(inner), test.area(outer) * 1.001f + 1e-3f);
  }
}

TEST(ContributionTest, FiltersSets) {
  std::size_t left_out = 0, stayed = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const std::size_t count = std::size_t(whole(random, 1, 900));
    core::ItemBounds bounds;
    bounds.resize(count);
    auto boxes = random_boxes(random, count, 10.0);
    if (seed % 2 == 0) spoil(random, boxes);
    const auto order = core::block_order(boxes);
    for (std::size_t i = 0; i < count; ++i) bounds.set(i, boxes[order[i]]);
    const View view = random_view(random, core::dvec3(0.0), 30.0);
    const ContributionTest test(view, core::dvec3(0.0), 64, 48);
    const culling::Hierarchy hierarchy(bounds);
    const float threshold = float(magnitude(random, 0.1, 1e4));
    core::VisibleSet in;
    in.ranges = {{0, std::uint32_t(count / 2)}};
    for (std::uint32_t s = std::uint32_t(count / 2); s < count; ++s)
      if (!bounds.vacant(s) && chance(random, 0.7)) in.items.push_back(s);
    std::vector<std::uint64_t> before(count / 64 + 1), exempt(count / 64 + 1);
    std::vector<core::Slot> expected;
    for (const core::Slot s : in.sorted_slots()) {
      if (bounds.vacant(s)) continue;
      const bool was = chance(random, 0.3), spared = chance(random, 0.02);
      if (was) before[s / 64] |= std::uint64_t(1) << s % 64;
      if (spared) exempt[s / 64] |= std::uint64_t(1) << s % 64;
      const float area = test.area(bounds.box(s));
      const bool stays = area < threshold && was && area >= ContributionTest::kHysteresis * threshold;
      if (area >= threshold || stays || spared) expected.push_back(s);
      stayed += stays;
    }
    for_each_instruction_set([&] {
      core::VisibleSet kept, leaves, both;
      test.filter(bounds, in, threshold, kept, before, exempt);
      ASSERT_EQ(kept.sorted_slots(), expected);
      test.filter_leaves(hierarchy, in, threshold, leaves, exempt);
      left_out += in.count() - leaves.count();
      test.filter(bounds, leaves, threshold, both, before, exempt);
      ASSERT_EQ(both.sorted_slots(), expected);
      std::vector<ContributionTest::SlotArea> areas;
      test.areas(bounds, in, areas);
      for (const auto& [slot, area] : areas) ASSERT_EQ(area, test.area(bounds.box(slot)));
    });
  }
  EXPECT_GT(left_out, 100u);
  EXPECT_GT(stayed, 25u);
}

}  // namespace
}  // namespace sightline::tests
