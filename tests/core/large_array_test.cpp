// The small tools under the flat arrays: large allocations, radix sort, the number before another.
#include "sightline/core/large_array.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/core/aabb.h"
#include "sightline/core/internal/radix_sort.h"

namespace sightline::core::large_array_test {
namespace {

TEST(LargeArray, StartsAtALineAndHoldsWhatItIsGiven) {
  for (const std::size_t count : {1u, 100u, 500'000u, 524'288u, 600'001u}) {
    LargeArray<float> array(count, 1.0f);
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(array.data()) % 64, 0u);
    array.push_back(2.0f);
    EXPECT_EQ(std::count(array.begin(), array.end(), 1.0f), std::ptrdiff_t(count));
    EXPECT_EQ(array.back(), 2.0f);
  }
}

TEST(LargeArray, LiesInMemoryOfOthersUntilItGrows) {
  const auto memory = std::make_shared<std::vector<int>>(std::vector<int>{1, 2, 3, 4});
  const std::weak_ptr<const void> keeper = memory;
  int* const values = memory->data();
  auto array = LargeArray<int>::kept(memory, values, 4);
  EXPECT_TRUE(array.is_kept());
  array[1] = 20;
  EXPECT_EQ(values[1], 20);
  LargeArray<int> copy = array;
  copy[0] = 7;
  EXPECT_FALSE(copy.is_kept());
  EXPECT_EQ(values[0], 1);
  const LargeArray<int> moved = std::move(array);
  EXPECT_EQ(moved.data(), values);
  array = LargeArray<int>::kept(memory, values, 4);
  array.push_back(array[3]);
  EXPECT_FALSE(array.is_kept());
  EXPECT_EQ(std::vector<int>(array.begin(), array.end()), (std::vector<int>{1, 20, 3, 4, 4}));
  array = {};
  copy = {};
  memory->clear();
  EXPECT_FALSE(keeper.expired());  // `moved` still needs it
}

TEST(LargeArray, KeepsItsValuesWhenItGrowsWithoutNewOnes) {
  LargeArray<int> array(3, 7);
  array.resize_for_overwrite(1'000'000);
  ASSERT_EQ(array.size(), 1'000'000u);
  EXPECT_EQ(std::vector<int>(array.begin(), array.begin() + 3), std::vector<int>(3, 7));
  array[999'999] = 8;
  EXPECT_EQ(array.back(), 8);
  array.resize_for_overwrite(2);
  EXPECT_EQ(std::vector<int>(array.begin(), array.end()), std::vector<int>(2, 7));
}

/// Grows from the heap into pages and from pages to more pages, with and without spare room.
TEST(LargeArray, MovesItsPagesWhenItGrows) {
  for (const bool spare : {false, true}) {
    LargeArray<std::uint32_t> array;
    std::uint32_t next = 0;
    for (const std::size_t count : {100'000u, 600'000u, 700'000u, 3'000'000u, 9'000'000u}) {
      array.reserve(count);
      if (spare) array.spare_room();
      while (next < count) array.push_back(next++);
      array.push_back(next++);
    }
    for (std::uint32_t i = 0; i < next; ++i) ASSERT_EQ(array[i], i);
  }
}

TEST(LargeArray, DoesAsStdVectorDoes) {
  std::mt19937 random(3);
  LargeArray<int> array;
  std::vector<int> twin;
  for (int step = 0; step < 20'000; ++step) {
    const int value = int(random());
    const std::size_t count = random() % (twin.size() + 10);
    switch (random() % 8) {
      case 0:
        array.resize(count, value), twin.resize(count, value);
        break;
      case 1:
        array.resize(count), twin.resize(count);
        break;
      case 2:
        array.assign(count % 50, value), twin.assign(count % 50, value);
        break;
      case 3: {
        const std::vector<int> own = twin;
        const std::size_t some = std::min<std::size_t>(own.size(), 20);
        array.insert(array.end(), array.begin(), array.begin() + some);  // of its own values
        twin.insert(twin.end(), own.begin(), own.begin() + std::ptrdiff_t(some));
        break;
      }
      case 4:
        array.reserve(count), twin.reserve(count);
        break;
      case 5:
        array.shrink_to_fit();
        break;
      default:
        array.push_back(array.empty() ? value : array.front());
        twin.push_back(twin.empty() ? value : int(twin.front()));
    }
    if (twin.size() > 500) array.resize(9), twin.resize(9);
    ASSERT_EQ(std::vector<int>(array.begin(), array.end()), twin) << step;
  }
}

TEST(RadixSort, SortsAsStdSortDoes) {
  std::mt19937_64 random(1);
  for (const std::size_t count : {0u, 1u, 2u, 511u, 512u, 5000u, 100'000u}) {
    std::vector<std::uint32_t> keys(count);
    for (std::uint32_t& key : keys) key = std::uint32_t(random()) >> random() % 32;
    auto expected = keys;
    std::sort(expected.begin(), expected.end());
    radix_sort(keys);
    ASSERT_EQ(keys, expected) << count;

    std::vector<std::uint64_t> wide(count);
    for (std::size_t i = 0; i < count; ++i) wide[i] = std::uint64_t(i * 2654435761u) << 32 | (i & 7);
    auto wide_expected = wide;
    std::sort(wide_expected.begin(), wide_expected.end());
    radix_sort<32>(wide);
    ASSERT_EQ(wide, wide_expected) << count;
  }
}

TEST(NextBelow, IsWhatNextafterGives) {
  std::mt19937_64 random(2);
  const double infinity = std::numeric_limits<double>::infinity();
  std::vector<double> values{0.0, -0.0, 1.0, -1.0, infinity, std::numeric_limits<double>::max()};
  for (int i = 0; i < 100'000; ++i) values.push_back(std::bit_cast<double>(random()));
  for (const double x : values) {
    if (std::isnan(x)) continue;
    ASSERT_EQ(next_below(x), std::nextafter(x, -infinity)) << x;
  }
  EXPECT_EQ(next_below(-infinity), -infinity);
  EXPECT_TRUE(std::isnan(next_below(std::numeric_limits<double>::quiet_NaN())));
}

}  // namespace
}  // namespace sightline::core::large_array_test
