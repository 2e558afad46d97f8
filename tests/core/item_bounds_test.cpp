#include "sightline/core/item_bounds.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/core/visible_set.h"

namespace sightline::core::item_bounds_test {
namespace {

constexpr std::size_t kPadding = ItemBounds::kPadding;

Aabb box_of(std::size_t i) {
  const float f = float(i);
  return {{f, f + 1, f + 2}, {f + 3, f + 4, f + 5}};
}

/// A group of kPadding may be read from any valid index, and what lies beyond the items is empty.
void expect_padded(const ItemBounds& bounds) {
  for (int axis = 0; axis < 6; ++axis)
    for (std::size_t i = bounds.size(); i < bounds.size() + kPadding; ++i)
      ASSERT_EQ(bounds.coordinate(axis)[i], axis < 3 ? Aabb::kFar : -Aabb::kFar) << "axis " << axis << " at " << i;
}

TEST(ItemBounds, AnyResizeKeepsBoxesAndPadding) {
  std::mt19937 random(1);
  ItemBounds bounds;
  bounds.resize(0);
  expect_padded(bounds);
  std::vector<Aabb> twin;
  for (int step = 0; step < 2000; ++step) {
    SCOPED_TRACE(step);
    // Small steps cross the padding, large ones reallocate.
    const std::size_t count = random() % (step % 3 == 0 ? 300 : 40);
    bounds.resize(count);
    twin.resize(count);
    for (std::size_t i = 0; i < count; i += 1 + random() % 4) {
      twin[i] = box_of(random() % 1000);
      bounds.set(i, twin[i]);
    }
    ASSERT_EQ(bounds.size(), count);
    for (std::size_t i = 0; i < count; ++i) {
      ASSERT_EQ(bounds.box(i).min, twin[i].min);
      ASSERT_EQ(bounds.box(i).max, twin[i].max);
    }
    ASSERT_NO_FATAL_FAILURE(expect_padded(bounds));
  }
}

TEST(ItemBounds, NewBoxesAreEmptyAndOnTheModelLayer) {
  ItemBounds bounds;
  bounds.resize(3);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_TRUE(bounds.box(i).empty());
    EXPECT_EQ(bounds.layers(i), kLayerModel);
  }
  EXPECT_FALSE(bounds.uses_layers());
  EXPECT_TRUE(bounds.extent().empty());
}

TEST(ItemBounds, CoordinatesLieAxisByAxis) {
  ItemBounds bounds;
  bounds.resize(2);
  bounds.set(1, box_of(10));
  for (int axis = 0; axis < 6; ++axis) EXPECT_EQ(bounds.coordinate(axis)[1], 10.0f + float(axis));
}

TEST(ItemBounds, LayersAreNoticedOnceUsed) {
  ItemBounds bounds;
  bounds.resize(4);
  bounds.set_layers(2, kLayerModel);
  EXPECT_FALSE(bounds.uses_layers());
  EXPECT_TRUE(bounds.layers().empty()) << "no memory for what all have in common";
  bounds.set_layers(2, 6);
  EXPECT_TRUE(bounds.uses_layers());
  EXPECT_EQ(bounds.layers()[2], 6u);
  EXPECT_EQ(bounds.layers(1), kLayerModel);
  EXPECT_EQ(bounds.layers().size(), 4u);
  bounds.resize(8);
  EXPECT_EQ(bounds.layers(2), 6u);
  EXPECT_EQ(bounds.layers(7), kLayerModel);
}

TEST(ItemBounds, ExtentCoversEveryBoxEverSet) {
  ItemBounds bounds;
  bounds.resize(2);
  bounds.set(0, {vec3(-5), vec3(-4)});
  bounds.set(0, {vec3(7), vec3(9)});
  bounds.set(1, {});
  EXPECT_EQ(bounds.extent().min, vec3(-5));
  EXPECT_EQ(bounds.extent().max, vec3(9));
}

TEST(VisibleSet, SortedSlotsAreRangesAndItemsTogether) {
  VisibleSet set;
  EXPECT_TRUE(set.sorted_slots().empty());
  set.ranges = {{2, 3}, {10, 1}};
  set.single_slots = {0, 7, 20};
  EXPECT_EQ(set.count(), 7u);
  EXPECT_EQ(set.sorted_slots(), (std::vector<Slot>{0, 2, 3, 4, 7, 10, 20}));
  set.counters.nodes_tested = 5;
  set.clear();
  EXPECT_EQ(set.count(), 0u);
  EXPECT_EQ(set.counters.nodes_tested, 0u);
}

// --- bounds for views of the whole -----------------------------------------------------------------------------------

/// 10 × 10 × 10 cubes of 1 m, 3 m apart, about the origin of the bounds.
std::vector<Aabb> grid() {
  std::vector<Aabb> boxes;
  for (int i = 0; i < 1000; ++i) {
    const vec3 p(float(3 * (i % 10) - 14), float(3 * (i / 10 % 10) - 14), float(3 * (i / 100) - 14));
    boxes.push_back({p, p + 1.0f});
  }
  return boxes;
}

ItemBounds bounds_of(const std::vector<Aabb>& boxes, const dvec3& origin = dvec3(0.0)) {
  ItemBounds bounds;
  bounds.origin = origin;
  bounds.resize(boxes.size());
  for (std::size_t i = 0; i < boxes.size(); ++i) bounds.set(i, boxes[i]);
  return bounds;
}

void expect_same(const AabbD& a, const AabbD& b) {
  EXPECT_EQ(a.min, b.min);
  EXPECT_EQ(a.max, b.max);
}

const AabbD kGrid{dvec3(-14.0), dvec3(14.0)};
const dvec3 kSite(1e7, -2e6, 100.0);

TEST(FittedBounds, WithoutOutliersAreTheWorldBounds) {
  expect_same(bounds_of(grid(), kSite).world_bounds(), {kGrid.min + kSite, kGrid.max + kSite});
  for (const dvec3& origin : {dvec3(0.0), kSite}) {
    const ItemBounds bounds = bounds_of(grid(), origin);
    expect_same(bounds.fitted_bounds().bounds, bounds.world_bounds());
    EXPECT_EQ(bounds.fitted_bounds().outliers, 0u);
  }
  EXPECT_TRUE(ItemBounds().world_bounds().empty());
  EXPECT_TRUE(ItemBounds().fitted_bounds().bounds.empty());
  EXPECT_TRUE(bounds_of(std::vector<Aabb>(500)).fitted_bounds().bounds.empty()) << "vacant places";
}

TEST(FittedBounds, LeaveOutAHundredthAtMost) {
  for (int axis = 0; axis < 3; ++axis)
    for (const float sign : {-1.0f, 1.0f})
      for (const std::size_t outliers : {1, 9, 10, 11, 50}) {
        SCOPED_TRACE(testing::Message() << outliers << " along " << sign << " of axis " << axis);
        std::vector<Aabb> boxes = grid();
        for (std::size_t i = 0; i < outliers; ++i) {
          vec3 p(0.0f);
          p[axis] = sign * (1000.0f + float(i));
          boxes.insert(boxes.begin() + std::ptrdiff_t(37 * i % boxes.size()), {p, p});
        }
        const ItemBounds bounds = bounds_of(boxes, kSite);
        const FittedBounds fitted = bounds.fitted_bounds();
        const bool few = outliers <= 10;
        EXPECT_EQ(fitted.outliers, few ? outliers : 0u);
        expect_same(fitted.bounds, few ? AabbD{kGrid.min + kSite, kGrid.max + kSite} : bounds.world_bounds());
      }
}

TEST(FittedBounds, FewerThanAHundredAreNeverLeftOut) {
  const std::vector<Aabb> all = grid();
  std::vector<Aabb> boxes(all.begin(), all.begin() + 98);
  boxes.push_back({vec3(1e6f), vec3(1e6f)});
  EXPECT_EQ(bounds_of(boxes).fitted_bounds().outliers, 0u);
  boxes.push_back(all[98]);
  EXPECT_EQ(bounds_of(boxes).fitted_bounds().outliers, 1u);
}

TEST(FittedBounds, FourfoldIsTheLimit) {
  // All but one reach 15 m from the middle, the origin.
  for (const auto& [reach, outliers] : {std::pair{1.0f, 0u}, {3.99f, 0u}, {4.01f, 1u}}) {
    std::vector<Aabb> boxes(999, Aabb{vec3(-15.0f), vec3(15.0f)});
    const vec3 p(0.0f, 0.0f, reach * 15.0f);
    boxes.push_back({p - 0.5f, p});
    EXPECT_EQ(bounds_of(boxes).fitted_bounds().outliers, outliers) << reach;
    // What is large reaches far, wherever its centre is.
    boxes.back() = {vec3(-reach * 15.0f), vec3(reach * 15.0f)};
    EXPECT_EQ(bounds_of(boxes).fitted_bounds().outliers, outliers) << reach;
  }
}

TEST(FittedBounds, AtOnePlaceNothingIsFar) {
  std::vector<Aabb> boxes(999, Aabb{vec3(5.0f), vec3(5.0f)});
  boxes.push_back({vec3(6.0f), vec3(7.0f)});
  const FittedBounds fitted = bounds_of(boxes).fitted_bounds();
  EXPECT_EQ(fitted.outliers, 0u);
  expect_same(fitted.bounds, {dvec3(5.0), dvec3(7.0)});
}

TEST(FittedBounds, HiddenLayersHaveNoSay) {
  std::vector<Aabb> boxes = grid();
  boxes.push_back({vec3(1e6f), vec3(1e6f)});
  boxes.resize(1200);  // vacant
  ItemBounds bounds = bounds_of(boxes);
  bounds.set_layers(1000, kLayerObstruction);
  EXPECT_EQ(bounds.fitted_bounds().outliers, 0u);
  expect_same(bounds.fitted_bounds().bounds, kGrid);
  expect_same(bounds.world_bounds(), kGrid);
  EXPECT_EQ(bounds.fitted_bounds(kDefaultLayerMask | kLayerObstruction).outliers, 1u);
  expect_same(bounds.world_bounds(kLayerObstruction), {dvec3(1e6), dvec3(1e6)});
  EXPECT_TRUE(bounds.world_bounds(kLayerInsulation).empty());

  // Nor do they make others look near.
  boxes = grid();
  for (int i = 0; i < 50; ++i) boxes.push_back({vec3(1e6f), vec3(1e6f)});
  bounds = bounds_of(boxes);
  for (std::size_t i = 1001; i < 1050; ++i) bounds.set_layers(i, kLayerObstruction);
  EXPECT_EQ(bounds.fitted_bounds().outliers, 1u);
  expect_same(bounds.fitted_bounds().bounds, kGrid);
}

/// The rule once more, by sorting.
FittedBounds sorted_twin(const std::vector<Aabb>& boxes) {
  const std::size_t n = boxes.size();
  const auto sorted = [&](auto value_of) {
    std::vector<float> values;
    for (const Aabb& box : boxes) values.push_back(value_of(box));
    std::sort(values.begin(), values.end());
    return values;
  };
  vec3 middle;
  for (int axis = 0; axis < 3; ++axis)
    middle[axis] = sorted([&](const Aabb& b) { return 0.5f * b.min[axis] + 0.5f * b.max[axis]; })[n / 2];
  const auto reach = [&](const Aabb& b) {
    float most = 0.0f;
    for (int axis = 0; axis < 3; ++axis)
      for (const float side : {b.min[axis], b.max[axis]}) most = std::max(most, std::abs(side - middle[axis]));
    return most;
  };
  const float limit = 4.0f * sorted(reach)[n - n / 100 - 1];
  FittedBounds fitted;
  for (const Aabb& box : boxes) {
    if (limit > 0.0f && reach(box) > limit)
      ++fitted.outliers;
    else
      fitted.bounds.grow({dvec3(box.min), dvec3(box.max)});
  }
  return fitted;
}

TEST(FittedBounds, EqualTheirTwin) {
  std::size_t with_outliers = 0;
  for (unsigned seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> unit(-1.0f, 1.0f), exponent(0.0f, 2.5f);
    std::vector<Aabb> boxes(seed == 0 ? 70'000 : 100 + seed * 7);  // several threads share many
    for (Aabb& box : boxes) {
      const float far = random() % 200 == 0 ? std::pow(10.0f, exponent(random)) : 1.0f;
      const vec3 p = far * vec3(unit(random), unit(random), unit(random));
      box = {p, p + 0.1f * (unit(random) + 1.0f)};
    }
    const FittedBounds fitted = bounds_of(boxes).fitted_bounds(), twin = sorted_twin(boxes);
    ASSERT_EQ(fitted.outliers, twin.outliers);
    expect_same(fitted.bounds, twin.bounds);
    EXPECT_LE(fitted.outliers, boxes.size() / 100);
    with_outliers += fitted.outliers > 0;
  }
  EXPECT_GT(with_outliers, 50u);
  EXPECT_LT(with_outliers, 290u);
}

}  // namespace
}  // namespace sightline::core::item_bounds_test
