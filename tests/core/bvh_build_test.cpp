#include "sightline/core/internal/bvh_build.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <span>
#include <utility>

#include <gtest/gtest.h>

namespace sightline::core {
namespace {

using Random = std::mt19937_64;

float uniform(Random& random, double low, double high) {
  return float(std::uniform_real_distribution<double>(low, high)(random));
}

std::vector<Aabb> random_boxes(std::size_t count, std::uint64_t seed, double site = 1000.0, double size = 5.0) {
  Random random(seed);
  std::vector<Aabb> boxes(count);
  for (Aabb& b : boxes) {
    for (int i = 0; i < 3; ++i) {
      b.min[i] = uniform(random, -site, site);
      b.max[i] = b.min[i] + uniform(random, 0.0, size);
    }
  }
  return boxes;
}

std::uint32_t ceil_log2(std::size_t n) {
  return n <= 1 ? 0 : std::uint32_t(std::bit_width(n - 1));
}

/// Everything bvh_build.h promises of any tree.
void expect_valid(const BvhTree& tree, std::size_t count, const BvhConfig& config = {}) {
  ASSERT_EQ(tree.order.size(), count);
  std::vector<bool> seen(count, false);
  for (const std::uint32_t i : tree.order) {
    ASSERT_LT(i, count);
    ASSERT_FALSE(seen[i]) << "box " << i << " twice in the order";
    seen[i] = true;
  }
  if (count == 0) {
    EXPECT_TRUE(tree.nodes.empty());
    return;
  }
  ASSERT_FALSE(tree.nodes.empty());
  ASSERT_EQ(tree.nodes[0].first, 0u);
  ASSERT_EQ(tree.nodes[0].count, count);
  // Children come after their parents, so one pass finds every node's depth.
  constexpr std::uint32_t kUnreached = 0xffffffffu;
  std::vector<std::uint32_t> depth(tree.nodes.size(), kUnreached);
  depth[0] = 0;
  std::uint32_t deepest = 0;
  for (std::size_t n = 0; n < tree.nodes.size(); ++n) {
    const BvhNode& node = tree.nodes[n];
    ASSERT_NE(depth[n], kUnreached) << "node " << n << " hangs nowhere";
    deepest = std::max(deepest, depth[n]);
    ASSERT_GT(node.count, 0u);
    if (node.leaf()) {
      ASSERT_LE(node.count, config.max_leaf_size);
      continue;
    }
    ASSERT_GT(node.count, config.max_leaf_size) << "split without need";
    ASSERT_GT(node.left, n);
    ASSERT_LT(node.left + 1, tree.nodes.size());
    const BvhNode &left = tree.nodes[node.left], &right = tree.nodes[node.left + 1];
    ASSERT_EQ(left.first, node.first);
    ASSERT_EQ(right.first, left.first + left.count);
    ASSERT_EQ(left.count + right.count, node.count);
    for (const std::uint32_t child : {node.left, node.left + 1}) {
      ASSERT_EQ(depth[child], kUnreached) << "two parents";
      depth[child] = depth[n] + 1;
    }
  }
  EXPECT_EQ(tree.depth, deepest);
  EXPECT_LE(tree.depth, 2 * ceil_log2(count) + 32);
}

void expect_same(const BvhTree& a, const BvhTree& b) {
  EXPECT_EQ(a.depth, b.depth);
  EXPECT_EQ(a.order, b.order);
  ASSERT_EQ(a.nodes.size(), b.nodes.size());
  for (std::size_t i = 0; i < a.nodes.size(); ++i) {
    ASSERT_EQ(a.nodes[i].first, b.nodes[i].first);
    ASSERT_EQ(a.nodes[i].count, b.nodes[i].count);
    ASSERT_EQ(a.nodes[i].left, b.nodes[i].left);
  }
}

void expect_valid_for(const std::vector<Aabb>& boxes) {
  for (const BvhSplit split : {BvhSplit::kBlocks, BvhSplit::kSurface}) {
    for (const std::uint32_t leaf : {1u, 8u, 64u}) {
      SCOPED_TRACE(testing::Message() << "split " << int(split) << ", leaf size " << leaf);
      BvhConfig config;
      config.split = split;
      config.max_leaf_size = leaf;
      ASSERT_NO_FATAL_FAILURE(expect_valid(build_bvh(boxes, config), boxes.size(), config));
    }
  }
}

TEST(BvhBuild, SmallCounts) {
  for (std::size_t count = 0; count <= 70; ++count) {
    SCOPED_TRACE(count);
    const auto boxes = random_boxes(count, count);
    const BvhTree tree = build_bvh(boxes);
    expect_valid(tree, count);
    if (count > 0 && count <= 8) {
      EXPECT_EQ(tree.nodes.size(), 1u);
    }
    if (count == 9) {
      EXPECT_EQ(tree.nodes.size(), 3u);
    }
    expect_valid_for(boxes);
  }
}

TEST(BvhBuild, RandomBoxesOfAnyConfig) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const auto boxes = random_boxes(random() % 3000, seed, std::pow(10.0, uniform(random, -3, 7)),
                                    std::pow(10.0, uniform(random, -6, 5)));
    BvhConfig config;
    config.max_leaf_size = 1 + std::uint32_t(random() % 20);
    config.split = random() % 2 == 0 ? BvhSplit::kBlocks : BvhSplit::kSurface;
    config.bins = std::uint32_t(random() % 100);  // also beyond what is allowed: clamped
    ASSERT_NO_FATAL_FAILURE(expect_valid(build_bvh(boxes, config), boxes.size(), config));
  }
}

TEST(BvhBuild, CoincidentCentroids) {
  // Shells around one point: no plane parts their centroids.
  std::vector<Aabb> boxes;
  for (int i = 1; i <= 20000; ++i) boxes.push_back({vec3(-float(i)), vec3(float(i))});
  expect_valid_for(boxes);
  EXPECT_LE(build_bvh(boxes).depth, ceil_log2(boxes.size()));
}

TEST(BvhBuild, DenormalAndHugeExtents) {
  const float tiny = std::numeric_limits<float>::denorm_min();
  Random random(1);
  std::vector<Aabb> denormal, huge, mixed;
  for (int i = 0; i < 5000; ++i) {
    const auto point = [&](double scale) {
      return vec3(uniform(random, -scale, scale), uniform(random, -scale, scale), uniform(random, -scale, scale));
    };
    vec3 p;
    for (int a = 0; a < 3; ++a) p[a] = tiny * float(random() % 1000);
    denormal.push_back({p, p + vec3(tiny)});
    const vec3 q = point(1e38), r = point(1e38);
    huge.push_back({glm::min(q, r), glm::max(q, r)});
    mixed.push_back(i % 3 == 0 ? denormal.back() : i % 3 == 1 ? huge.back() : Aabb{vec3(-1.0f), vec3(1.0f)});
  }
  const float most = std::numeric_limits<float>::max();
  mixed.push_back({vec3(-most), vec3(most)});
  mixed.push_back({vec3(-most), vec3(-most)});
  mixed.push_back({vec3(most), vec3(most)});
  expect_valid_for(denormal);
  expect_valid_for(huge);
  expect_valid_for(mixed);
}

TEST(BvhBuild, OneGiantAmongDust) {
  auto boxes = random_boxes(20000, 3, 1.0, 1e-4);
  boxes.push_back({vec3(-1e30f), vec3(1e30f)});
  boxes.push_back({vec3(1e30f), vec3(2e30f)});
  expect_valid_for(boxes);
}

TEST(BvhBuild, ExponentiallySpacedBoxes) {
  // Every split by equal bins takes one box off: the depth bound must step in.
  std::vector<Aabb> boxes;
  for (int copies = 0; copies < 40; ++copies)
    for (int i = 0; i < 140; ++i) {
      const float x = std::ldexp(1.0f, -i);
      boxes.push_back({vec3(x, 0, 0), vec3(1.01f * x, 1e-3f * x, 0)});
    }
  expect_valid_for(boxes);
  std::vector<Aabb> both_ways;
  for (int i = -140; i < 120; ++i) {
    const float x = std::ldexp(1.0f, i);
    both_ways.push_back({vec3(x), vec3(x)});
    both_ways.push_back({vec3(-x), vec3(-x)});
  }
  expect_valid_for(both_ways);
}

TEST(BvhBuild, EmptyBoxesAmongOthersAndAlone) {
  auto boxes = random_boxes(5000, 4);
  Random random(4);
  for (Aabb& b : boxes)
    if (random() % 3 == 0) b = {};
  expect_valid_for(boxes);
  expect_valid_for(std::vector<Aabb>(1000));
}

TEST(BvhBuild, MillionsOfIdenticalBoxes) {
#ifdef NDEBUG
  const std::size_t count = 10'000'000;
#else
  const std::size_t count = 1'000'000;
#endif
  const std::vector<Aabb> boxes(count, Aabb{vec3(1.0f), vec3(2.0f)});
  const BvhTree tree = build_bvh(boxes);
  expect_valid(tree, count);
  EXPECT_LE(tree.depth, ceil_log2(count));
}

TEST(BvhBuild, TheTreeDoesNotDependOnThreads) {
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    SCOPED_TRACE(seed);
    auto boxes = random_boxes(100'000, seed);
    if (seed == 1) {
      for (Aabb& b : boxes) b.min = glm::floor(b.min / 100.0f) * 100.0f, b.max = b.min + 1.0f;  // many ties
    }
    for (const BvhSplit split : {BvhSplit::kBlocks, BvhSplit::kSurface}) {
      BvhConfig config;
      config.split = split;
      config.threads = 1;
      const BvhTree one = build_bvh(boxes, config);
      expect_valid(one, boxes.size());
      for (const int threads : {0, 1, 2, 4}) {
        config.threads = threads;
        expect_same(one, build_bvh(boxes, config));
      }
    }
  }
}

// --- quality ---------------------------------------------------------------------------------------------------------

double half_area(const Aabb& box) {
  const dvec3 d = dvec3(box.max) - dvec3(box.min);
  return d.x * d.y + d.y * d.z + d.z * d.x;
}

/// Sum of the nodes' surfaces: what a random ray or view is likely to enter.
double total_surface(const BvhTree& tree, const std::vector<Aabb>& boxes) {
  double sum = 0.0;
  for (const BvhNode& node : tree.nodes) {
    Aabb box;
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) box.grow(boxes[tree.order[i]]);
    sum += half_area(box);
  }
  return sum;
}

/// Halves by the longest axis of the centroids: the plain builder that the heuristic has to beat.
BvhTree median_tree(const std::vector<Aabb>& boxes) {
  BvhTree tree;
  tree.order.resize(boxes.size());
  for (std::uint32_t i = 0; i < boxes.size(); ++i) tree.order[i] = i;
  tree.nodes.push_back({0, std::uint32_t(boxes.size()), 0});
  const auto centre = [&](std::uint32_t i) { return boxes[i].min + boxes[i].max; };
  for (std::size_t n = 0; n < tree.nodes.size(); ++n) {
    const BvhNode node = tree.nodes[n];
    if (node.count <= 8) continue;
    Aabb all;
    const auto begin = tree.order.begin() + node.first;
    for (std::uint32_t i = 0; i < node.count; ++i) all.grow({centre(begin[i]), centre(begin[i])});
    const vec3 d = all.max - all.min;
    const int axis = d.x > d.y && d.x > d.z ? 0 : d.y > d.z ? 1 : 2;
    std::nth_element(begin, begin + node.count / 2, begin + node.count,
                     [&](std::uint32_t a, std::uint32_t b) { return centre(a)[axis] < centre(b)[axis]; });
    tree.nodes[n].left = std::uint32_t(tree.nodes.size());
    tree.nodes.push_back({node.first, node.count / 2, 0});
    tree.nodes.push_back({node.first + node.count / 2, node.count - node.count / 2, 0});
  }
  return tree;
}

/// What the cullers' hierarchy builds on: aligned blocks are subtrees, and split what lies along the longest axis.
TEST(BvhBuild, BlocksAreAlignedAndSorted) {
  const auto boxes = random_boxes(5000, 9);
  BvhConfig config;
  config.max_leaf_size = 4;
  const BvhTree tree = build_bvh(boxes, config);
  for (const BvhNode& node : tree.nodes) {
    ASSERT_EQ(node.first % std::bit_ceil(node.count), 0u);
    if (node.leaf()) continue;
    const BvhNode &left = tree.nodes[node.left], &right = tree.nodes[node.left + 1];
    ASSERT_TRUE(std::has_single_bit(left.count));
    const auto centre = [&](std::uint32_t place) {
      const Aabb& b = boxes[tree.order[place]];
      return 0.5f * b.min + 0.5f * b.max;
    };
    Aabb all;
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) all.grow({centre(i), centre(i)});
    const vec3 d = all.max - all.min;
    const int axis = d.x >= d.y && d.x >= d.z ? 0 : d.y >= d.z ? 1 : 2;
    float highest = -Aabb::kFar, lowest = Aabb::kFar;
    for (std::uint32_t i = left.first; i < left.first + left.count; ++i) highest = std::max(highest, centre(i)[axis]);
    for (std::uint32_t i = right.first; i < right.first + right.count; ++i) lowest = std::min(lowest, centre(i)[axis]);
    ASSERT_LE(highest, lowest);
  }
}

/// The blocks' twin: sorts every node in full.
void sort_blocks(const std::vector<Aabb>& boxes, std::uint32_t leaf, std::span<std::uint32_t> order) {
  if (order.size() <= leaf) return;
  const auto centre = [&](std::uint32_t i) { return 0.5f * boxes[i].min + 0.5f * boxes[i].max; };
  Aabb all;
  for (const std::uint32_t i : order) all.grow({centre(i), centre(i)});
  const dvec3 d = dvec3(all.max) - dvec3(all.min);
  const int axis = d.x >= d.y && d.x >= d.z ? 0 : d.y >= d.z ? 1 : 2;
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::pair(centre(a)[axis], a) < std::pair(centre(b)[axis], b);
  });
  const std::size_t left = std::bit_ceil(order.size()) / 2;
  sort_blocks(boxes, leaf, order.first(left));
  sort_blocks(boxes, leaf, order.subspan(left));
}

TEST(BvhBuild, BlocksHoldWhatSortingPutsThere) {
  for (std::uint64_t seed = 0; seed < 24; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    // Also more than the builder's threads share among them.
    const std::size_t count = seed % 4 == 0 ? 40'000 + random() % 60'000 : 1 + random() % 3000;
    auto boxes = random_boxes(count, seed, std::pow(10.0, uniform(random, -3, 7)));
    for (Aabb& b : boxes) {
      if (seed % 3 == 1) b.min = glm::floor(b.min / 100.0f) * 100.0f, b.max = b.min;  // many ties
      if (seed % 3 == 2 && random() % 10 != 0) b.min *= 1e-6f, b.max *= 1e-6f;        // nearly all in one bucket
    }
    BvhConfig config;
    config.max_leaf_size = 1u << (random() % 6);
    std::vector<std::uint32_t> expected(count);
    std::iota(expected.begin(), expected.end(), 0u);
    sort_blocks(boxes, config.max_leaf_size, expected);
    for (const int threads : {1, 2, 3}) {
      config.threads = threads;
      BvhTree tree = build_bvh(boxes, config);
      std::vector<std::uint32_t> twin = expected;
      for (const BvhNode& node : tree.nodes) {
        if (!node.leaf()) continue;
        for (auto* order : {&tree.order, &twin})
          std::sort(order->begin() + node.first, order->begin() + node.first + node.count);
      }
      ASSERT_EQ(tree.order, twin);
    }
  }
}

TEST(BvhBuild, TheWholeOfSpaceHasAPlace) {
  const float infinity = std::numeric_limits<float>::infinity();
  auto boxes = random_boxes(40'000, 5);
  for (std::size_t i = 0; i < boxes.size(); i += 7) boxes[i] = {vec3(-infinity), vec3(infinity)};
  expect_valid_for(boxes);
  for (std::size_t i = 0; i < boxes.size(); i += 5) boxes[i] = {vec3(infinity), vec3(infinity)};
  BvhConfig config;
  expect_valid(build_bvh(boxes, config), boxes.size(), config);
}

TEST(BvhBuild, BeatsMedianSplitsWhereThingsCluster) {
  Random random(6);
  std::vector<Aabb> boxes;
  for (int cluster = 0; cluster < 60; ++cluster) {
    const vec3 centre(uniform(random, -500, 500), uniform(random, -500, 500), uniform(random, 0, 50));
    const int members = 1 + int(random() % 400);
    for (int i = 0; i < members; ++i) {
      vec3 p = centre, q;
      for (int a = 0; a < 3; ++a) p[a] += uniform(random, -5, 5), q[a] = p[a] + uniform(random, 0.01, 0.5);
      boxes.push_back({p, q});
    }
  }
  BvhConfig config;
  config.split = BvhSplit::kSurface;
  config.max_leaf_size = 8;
  EXPECT_LT(total_surface(build_bvh(boxes, config), boxes), 0.9 * total_surface(median_tree(boxes), boxes));
}

}  // namespace
}  // namespace sightline::core
