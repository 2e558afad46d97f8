// The estimate of how large items look, against all items and against sizes that are plain to see.
#include "sightline/culling/occlusion/internal/item_sizes.h"

#include <cmath>

#include <gtest/gtest.h>

namespace sightline::culling::item_sizes_test {
namespace {

using core::View;

constexpr int kHeight = 200;

/// Cubes in a row that goes away from the eye, of the diagonal 1.
core::ItemBounds row_of_cubes(std::size_t count, float nearest, float step) {
  core::ItemBounds bounds;
  bounds.resize(count);
  const core::vec3 half(0.5f / std::sqrt(3.0f));
  for (std::size_t i = 0; i < count; ++i) {
    const core::vec3 middle(0.0f, nearest + float(i) * step, 0.0f);
    bounds.set(i, {middle - half, middle + half});
  }
  return bounds;
}

View sight(double eye_y = 0.0) {
  return *View::perspective({{0, eye_y, 0}, {0, eye_y + 1.0, 0}, {0, 0, 1}}, 2.0 * std::atan(0.5), 1.0, 0.1);
}

TEST(ItemSizes, AreThoseOfTheDiagonals) {
  const core::ItemBounds one = row_of_cubes(1, 10.0f, 0.0f);
  core::VisibleSet set;
  EXPECT_EQ(mean_area(sight(), one, set, kHeight), 0.0);
  set.single_slots = {0};
  EXPECT_NEAR(mean_area(sight(), one, set, kHeight), 400.0, 1e-2);  // a tenth of 200 pixels is 20
  EXPECT_NEAR(mean_area(sight(-10.0), one, set, kHeight), 100.0, 1e-2);
  EXPECT_NEAR(mean_area(sight(), one, set, 2 * kHeight), 1600.0, 1e-1);
  EXPECT_EQ(mean_area(sight(9.5), one, set, kHeight), 1e4) << "one very near item counts no more";
  const View parallel = *View::orthographic({{0, 0, 0}, {0, 1, 0}, {0, 0, 1}}, 50.0, 1.0, -100.0, 100.0);
  EXPECT_NEAR(mean_area(parallel, one, set, kHeight), 16.0, 1e-3);  // a fiftieth of 200 pixels
}

TEST(ItemSizes, AreNearlyTheMeanOfAll) {
  const core::ItemBounds row = row_of_cubes(20'000, 5.0f, 0.01f);
  core::VisibleSet set;
  set.ranges = {{0, 7'000}, {9'000, 1'000}};
  for (core::Slot slot = 10'000; slot < 20'000; slot += 2) set.single_slots.push_back(slot);
  double sum = 0.0;
  set.for_each_slot([&](core::Slot slot) { sum += std::pow(kHeight / (5.0 + 0.01 * slot), 2.0); });
  const double exact = sum / double(set.count());
  EXPECT_NEAR(mean_area(sight(), row, set, kHeight), exact, 0.05 * exact);
}

TEST(ItemSizes, VacantSlotsAreNone) {
  core::ItemBounds row = row_of_cubes(10, 10.0f, 0.0f);
  for (std::size_t i = 0; i < 9; ++i) row.set(i, core::Aabb());
  core::VisibleSet set;
  set.ranges = {{0, 10}};
  EXPECT_NEAR(mean_area(sight(), row, set, kHeight), 400.0, 1e-2);
  set.ranges = {{0, 9}};
  EXPECT_EQ(mean_area(sight(), row, set, kHeight), 0.0);
}

}  // namespace
}  // namespace sightline::culling::item_sizes_test
