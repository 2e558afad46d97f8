#include "sightline/core/block_order.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <numeric>

#include <gtest/gtest.h>

#include "sightline/tests/support/box_sets.h"

namespace sightline::core::block_order_test {
namespace {

using tests::boxes_in_a_site;
using tests::uniform_float;
using Random = std::mt19937_64;

void expect_permutation(const std::vector<std::uint32_t>& order, std::size_t count) {
  ASSERT_EQ(order.size(), count);
  std::vector<bool> seen(count, false);
  for (const std::uint32_t i : order) {
    ASSERT_LT(i, count);
    ASSERT_FALSE(seen[i]) << "box " << i << " twice in the order";
    seen[i] = true;
  }
}

TEST(BlockOrder, NamesEachBoxOnce) {
  for (std::size_t count = 0; count <= 70; ++count)
    expect_permutation(block_order(boxes_in_a_site(count, count)), count);
  for (const auto& [name, boxes] : tests::hard_box_sets())
    for (const std::uint32_t block : {1u, 8u, 64u}) {
      SCOPED_TRACE(testing::Message() << name << ", blocks of " << block);
      expect_permutation(block_order(boxes, {.smallest_block = block}), boxes.size());
    }
}

TEST(BlockOrder, MillionsOfIdenticalBoxes) {
#ifdef NDEBUG
  const std::size_t count = 10'000'000;
#else
  const std::size_t count = 1'000'000;
#endif
  const std::vector<Aabb> boxes(count, Aabb{vec3(1.0f), vec3(2.0f)});
  expect_permutation(block_order(boxes), count);
}

TEST(BlockOrder, DoesNotDependOnThreads) {
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    SCOPED_TRACE(seed);
    auto boxes = boxes_in_a_site(100'000, seed);
    if (seed == 1) {
      for (Aabb& b : boxes) b.min = glm::floor(b.min / 100.0f) * 100.0f, b.max = b.min + 1.0f;  // many ties
    }
    const auto one = block_order(boxes, {.threads = 1});
    expect_permutation(one, boxes.size());
    for (const int threads : {0, 1, 2, 4}) EXPECT_EQ(one, block_order(boxes, {.threads = threads}));
  }
}

/// The twin: sorts every block in full, its centroids and then the boxes' numbers.
void sort_blocks(const std::vector<Aabb>& boxes, std::uint32_t smallest, std::span<std::uint32_t> order) {
  if (order.size() <= smallest) return std::sort(order.begin(), order.end());  // in no particular order
  const auto centre = [&](std::uint32_t i) { return 0.5f * boxes[i].min + 0.5f * boxes[i].max; };
  Aabb all;
  for (const std::uint32_t i : order) all.grow({centre(i), centre(i)});
  const dvec3 d = dvec3(all.max) - dvec3(all.min);
  const int axis = d.x >= d.y && d.x >= d.z ? 0 : d.y >= d.z ? 1 : 2;
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::pair(centre(a)[axis], a) < std::pair(centre(b)[axis], b);
  });
  const std::size_t left = std::bit_ceil(order.size()) / 2;
  sort_blocks(boxes, smallest, order.first(left));
  sort_blocks(boxes, smallest, order.subspan(left));
}

/// The smallest blocks are in no particular order: sorts those of an order by number.
void sort_smallest_blocks(std::uint32_t smallest, std::span<std::uint32_t> order) {
  if (order.size() <= smallest) return std::sort(order.begin(), order.end());
  const std::size_t left = std::bit_ceil(order.size()) / 2;
  sort_smallest_blocks(smallest, order.first(left));
  sort_smallest_blocks(smallest, order.subspan(left));
}

TEST(BlockOrder, BlocksHoldWhatSortingPutsThere) {
  for (std::uint64_t seed = 0; seed < 24; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    // Also more than the builder's threads share among them.
    const std::size_t count = seed % 4 == 0 ? 40'000 + random() % 60'000 : 1 + random() % 3000;
    auto boxes = boxes_in_a_site(count, seed, std::pow(10.0, uniform_float(random, -3, 7)));
    for (Aabb& b : boxes) {
      if (seed % 3 == 1) b.min = glm::floor(b.min / 100.0f) * 100.0f, b.max = b.min;  // many ties
      if (seed % 3 == 2 && random() % 10 != 0) b.min *= 1e-6f, b.max *= 1e-6f;        // nearly all in one bucket
    }
    const std::uint32_t smallest = 1u << (random() % 6);
    std::vector<std::uint32_t> expected(count);
    std::iota(expected.begin(), expected.end(), 0u);
    sort_blocks(boxes, smallest, expected);
    for (const int threads : {1, 2, 3}) {
      std::vector<std::uint32_t> order = block_order(boxes, {smallest, threads});
      sort_smallest_blocks(smallest, order);
      ASSERT_EQ(order, expected);
    }
  }
}

}  // namespace
}  // namespace sightline::core::block_order_test
