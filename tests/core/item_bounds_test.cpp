#include "sightline/core/item_bounds.h"

#include <random>

#include <gtest/gtest.h>

#include "sightline/core/visible_set.h"

namespace sightline::core {
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
  set.items = {0, 7, 20};
  EXPECT_EQ(set.count(), 7u);
  EXPECT_EQ(set.sorted_slots(), (std::vector<Slot>{0, 2, 3, 4, 7, 10, 20}));
  set.counters.nodes_tested = 5;
  set.clear();
  EXPECT_EQ(set.count(), 0u);
  EXPECT_EQ(set.counters.nodes_tested, 0u);
}

}  // namespace
}  // namespace sightline::core
