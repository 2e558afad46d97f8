// The small tools under the flat arrays: large allocations, radix sort, the number before another.
#include "sightline/core/internal/large_array.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "sightline/core/aabb.h"
#include "sightline/core/internal/radix_sort.h"

namespace sightline::core {
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
}  // namespace sightline::core
