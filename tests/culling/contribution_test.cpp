// Projected areas against the convex hull of the corners in double, what they leave out, and squares in its place.
#include "sightline/culling/occlusion/contribution.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "exact_samples.h"

namespace sightline::tests::contribution_test {
namespace {

using culling::ContributionTest;

/// The area of the convex hull (A. Andrew, "Another efficient algorithm for convex hulls in two dimensions", 1979).
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

/// Pixels of a square metre that faces the eye at `centre`, by small steps across the line of sight.
double facing_pixels(const View& view, const core::dvec3& centre, int width, int height, core::dvec2& place,
                     double& distance) {
  const core::dvec4 at = view.eye_from_world() * core::dvec4(centre, 1.0);
  const core::dvec3 ray = view.orthographic() ? core::dvec3(0, 0, -1) : glm::normalize(core::dvec3(at));
  const core::dvec3 other = std::abs(ray.x) < 0.5 ? core::dvec3(1, 0, 0) : core::dvec3(0, 1, 0);
  const core::dvec3 across[2] = {glm::normalize(glm::cross(ray, other)),
                                 glm::cross(ray, glm::normalize(glm::cross(ray, other)))};
  const auto project = [&](const core::dvec3& eye) {
    const core::dvec4 clip = view.clip_from_eye() * core::dvec4(eye, 1.0);
    return 0.5 * core::dvec2(width, height) * (core::dvec2(clip) / clip.w + 1.0) - 0.5;
  };
  place = project(core::dvec3(at));
  distance = -at.z;
  const double step = 1e-4 * std::max(1e-3, std::abs(at.z));
  core::dvec2 moves[2];
  for (int i = 0; i < 2; ++i)
    moves[i] =
        (project(core::dvec3(at) + step * across[i]) - project(core::dvec3(at) - step * across[i])) / (2.0 * step);
  return std::abs(moves[0].x * moves[1].y - moves[0].y * moves[1].x);
}

struct SplatCounts {
  std::size_t limited = 0, shown = 0, between = 0, outside = 0;

  void add(const SplatCounts& other) {
    limited += other.limited, shown += other.shown, between += other.between, outside += other.outside;
  }
};

/// Areas and squares of solids against double precision.
TEST(ContributionTest, SolidsLimitAreasAndMakeSquares) {
  SplatCounts all_seeds;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const RandomSite site(random);
    const core::dvec3 origin = site.origin;
    const core::View& view = site.view;
    const int width = whole(random, 1, 300), height = whole(random, 1, 200);
    const std::size_t count = std::size_t(whole(random, 1, 200));
    core::ItemBounds bounds;
    bounds.origin = origin;
    bounds.resize(count);
    std::vector<float> solids(count - count / 10);  // the last have none
    std::vector<std::uint64_t> without(culling::bit_words(count));
    for (std::size_t i = 0; i < count; ++i) {
      bounds.set(i, random_box(random, site.half));
      if (i < solids.size()) {
        const core::vec3 size = bounds.box(i).max - bounds.box(i).min;
        solids[i] = float(uniform(random, 0.0, 1.0)) * (size.x * size.y + size.y * size.z + size.z * size.x);
      }
      if (chance(random, 0.1)) without[i / 64] |= std::uint64_t(1) << i % 64;
    }
    core::VisibleSet in;
    in.ranges = {{0, std::uint32_t(count / 2)}};
    for (auto s = std::uint32_t(count / 2); s < count; ++s)
      if (!bounds.vacant(s) && chance(random, 0.7)) in.single_slots.push_back(s);
    const ContributionTest plain(view, origin, width, height), test(view, origin, width, height, solids);
    const float fixed = chance(random, 0.5) ? float(magnitude(random, 0.1, 100.0)) : 0.0f;
    SplatCounts counts;
    for_each_instruction_set([&] {
      counts = {};
      std::vector<ContributionTest::SlotArea> areas, outlines;
      plain.areas(bounds, in, outlines);
      test.areas(bounds, in, areas);
      std::vector<ContributionTest::Splat> all(1), on_centres(1);  // to be replaced
      test.splats(bounds, in, without, fixed, ContributionTest::SplatRule::kAll, all);
      test.splats(bounds, in, without, fixed, ContributionTest::SplatRule::kOnPixelCentres, on_centres);
      auto next = all.begin();
      auto next_on = on_centres.begin();
      for (std::size_t i = 0; i < areas.size(); ++i) {
        const core::Slot slot = areas[i].slot;
        const Aabb box = bounds.box(slot);
        const core::dvec3 centre = 0.5 * (core::dvec3(box.min) + core::dvec3(box.max)) + origin;
        core::dvec2 place;
        double distance;
        const double per_metre = facing_pixels(view, centre, width, height, place, distance);
        const bool has_square = next != all.end() && next->slot == slot;
        const double outline = outlines[i].area;
        if (std::isinf(outline) || culling::contains(without, slot)) {
          ASSERT_FALSE(has_square);
          continue;
        }
        const double reach = std::max(std::abs(place.x), std::abs(place.y));
        if (reach < 1e4 && slot < solids.size()) {
          const double exact = std::min(outline, double(solids[slot]) * per_metre);
          counts.limited += exact < outline;
          ASSERT_NEAR(areas[i].area, exact, 1e-3 * exact + 1e-3) << slot;
        } else if (slot >= solids.size()) {
          ASSERT_EQ(areas[i].area, outlines[i].area);
        }
        ASSERT_EQ(areas[i].area,
                  test.area(box, slot < solids.size() ? solids[slot] : std::numeric_limits<float>::infinity()));
        const double in_x = std::min(place.x + 0.5, width - 0.5 - place.x),
                     in_y = std::min(place.y + 0.5, height - 0.5 - place.y), in_by = std::min(in_x, in_y);
        if (std::abs(in_by) > 0.01 && (areas[i].area > 0.0f || in_by < 0.0)) {
          ASSERT_EQ(has_square, in_by > 0.0) << slot;
        }
        counts.outside += !has_square;
        if (!has_square) continue;
        ASSERT_NEAR(next->x, place.x, 0.01);
        ASSERT_NEAR(next->y, place.y, 0.01);
        ASSERT_NEAR(next->distance, distance, 1e-4 * (site.half + std::abs(distance)));
        ASSERT_EQ(next->area, areas[i].area);
        const double side = std::sqrt(double(std::max(fixed, next->area)));
        const auto covers = [&](float at, int size, double margin) {
          const double first = std::max(0.0, std::ceil(double(at) - 0.5 * side - margin));
          return first <= std::min(size - 1.0, double(at) + 0.5 * side + margin);
        };
        const bool on = next_on != on_centres.end() && next_on->slot == slot;
        if (covers(next->x, width, 0.0) && covers(next->y, height, 0.0)) {
          ASSERT_TRUE(on) << slot;
        }
        if (!covers(next->x, width, 0.02) || !covers(next->y, height, 0.02)) {
          ASSERT_FALSE(on) << slot;
        }
        ++(on ? counts.shown : counts.between);
        next_on += on;
        ++next;
      }
      ASSERT_EQ(next, all.end());
      ASSERT_EQ(next_on, on_centres.end());
    });
    all_seeds.add(counts);
  }
  EXPECT_GT(all_seeds.limited, 300u);
  EXPECT_GT(all_seeds.shown, 300u);
  EXPECT_GT(all_seeds.between, 30u);
  EXPECT_GT(all_seeds.outside, 300u);
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
    std::vector<float> solids(count / 2 + count / 3);
    for (float& solid : solids) solid = float(magnitude(random, 1e-3, 1e3));
    const ContributionTest test(view, core::dvec3(0.0), 64, 48, solids);
    const auto area_of = [&](core::Slot slot) {
      return test.area(bounds.box(slot), slot < solids.size() ? solids[slot] : std::numeric_limits<float>::infinity());
    };
    const culling::Hierarchy hierarchy(bounds);
    float threshold = float(magnitude(random, 0.1, 1e4));
    // As large as an item, or so that hysteresis keeps one just so.
    const float some_area = area_of(core::Slot(whole(random, 0, int(count) - 1)));
    if (some_area > 0.0f && std::isfinite(some_area) && chance(random, 0.5))
      threshold = chance(random, 0.5) ? some_area : some_area / ContributionTest::kHysteresis;
    core::VisibleSet in;
    in.generation = seed;
    in.counters.nodes_tested = 3;
    in.ranges = {{0, std::uint32_t(count / 2)}};
    for (std::uint32_t s = std::uint32_t(count / 2); s < count; ++s)
      if (!bounds.vacant(s) && chance(random, 0.7)) in.single_slots.push_back(s);
    std::vector<std::uint64_t> before(count / 64 + 1), exempt(count / 64 + 1);
    std::vector<core::Slot> expected;
    for (const core::Slot s : in.sorted_slots()) {
      const bool was = chance(random, 0.3), spared = chance(random, bounds.vacant(s) ? 0.5 : 0.02);
      if (was) before[s / 64] |= std::uint64_t(1) << s % 64;
      if (spared) exempt[s / 64] |= std::uint64_t(1) << s % 64;
      if (bounds.vacant(s)) continue;
      const float area = area_of(s);
      const bool stays = area < threshold && was && area >= ContributionTest::kHysteresis * threshold;
      if (area >= threshold || stays || spared) expected.push_back(s);
      stayed += stays;
    }
    core::VisibleSet leaves;
    std::vector<ContributionTest::SlotArea> areas;
    std::size_t occupied = 0;
    for (const core::Slot s : in.sorted_slots()) occupied += !bounds.vacant(s);
    for_each_instruction_set([&] {
      core::VisibleSet kept, both;
      test.filter(bounds, in, threshold, kept, before, exempt);
      ASSERT_EQ(kept.sorted_slots(), expected);
      ASSERT_EQ(kept.generation, seed);
      ASSERT_EQ(kept.counters.nodes_tested, 3u);
      test.filter_leaves(hierarchy, in, threshold, leaves, exempt);
      test.filter(bounds, leaves, threshold, both, before, exempt);
      ASSERT_EQ(both.sorted_slots(), expected);
      test.areas(bounds, in, areas);
      ASSERT_EQ(areas.size(), occupied);
      for (const auto& [slot, area] : areas) ASSERT_EQ(area, area_of(slot));
    });
    left_out += in.count() - leaves.count();
  }
  EXPECT_GT(left_out, 80u);
  EXPECT_GT(stayed, 25u);
}

}  // namespace
}  // namespace sightline::tests::contribution_test
