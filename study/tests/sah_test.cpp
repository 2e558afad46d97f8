#include "sightline/study/sah.h"

#include <algorithm>
#include <bit>

#include <gtest/gtest.h>

#include "sightline/tests/support/box_sets.h"

namespace sightline::study::sah_test {
namespace {

using core::Aabb;
using core::dvec3;
using core::vec3;
using tests::boxes_in_a_site;
using tests::uniform_float;
using Random = std::mt19937_64;

std::uint32_t ceil_log2(std::size_t n) {
  return n <= 1 ? 0 : std::uint32_t(std::bit_width(n - 1));
}

/// Everything sah.h promises of any tree.
void expect_valid(const SahTree& tree, std::size_t count, const SahConfig& config = {}) {
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
    const SahNode& node = tree.nodes[n];
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
    const SahNode &left = tree.nodes[node.left], &right = tree.nodes[node.left + 1];
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

TEST(Sah, BuildsValidTreesOfAnything) {
  for (std::size_t count = 0; count <= 70; ++count) {
    SCOPED_TRACE(count);
    const SahTree tree = build_sah(boxes_in_a_site(count, count));
    ASSERT_NO_FATAL_FAILURE(expect_valid(tree, count));
    if (count > 0 && count <= 8) {
      EXPECT_EQ(tree.nodes.size(), 1u);
    }
  }
  for (const auto& [name, boxes] : tests::hard_box_sets())
    for (const std::uint32_t leaf : {1u, 8u, 64u}) {
      SCOPED_TRACE(testing::Message() << name << ", leaf size " << leaf);
      ASSERT_NO_FATAL_FAILURE(expect_valid(build_sah(boxes, {.max_leaf_size = leaf}), boxes.size(), {leaf}));
    }
}

TEST(Sah, RandomBoxesOfAnyConfig) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const auto boxes = boxes_in_a_site(random() % 3000, seed, std::pow(10.0, uniform_float(random, -3, 7)),
                                       std::pow(10.0, uniform_float(random, -6, 5)));
    const SahConfig config{1 + std::uint32_t(random() % 20), std::uint32_t(random() % 100)};  // bins are clamped
    ASSERT_NO_FATAL_FAILURE(expect_valid(build_sah(boxes, config), boxes.size(), config));
  }
}

double half_area(const Aabb& box) {
  const dvec3 d = dvec3(box.max) - dvec3(box.min);
  return d.x * d.y + d.y * d.z + d.z * d.x;
}

/// Sum of the nodes' surfaces: what a random ray or view is likely to enter.
double total_surface(const SahTree& tree, const std::vector<Aabb>& boxes) {
  double sum = 0.0;
  for (const SahNode& node : tree.nodes) {
    Aabb box;
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) box.grow(boxes[tree.order[i]]);
    sum += half_area(box);
  }
  return sum;
}

/// Halves by the longest axis of the centroids: the plain builder that the heuristic has to beat.
SahTree median_tree(const std::vector<Aabb>& boxes) {
  SahTree tree;
  tree.order.resize(boxes.size());
  for (std::uint32_t i = 0; i < boxes.size(); ++i) tree.order[i] = i;
  tree.nodes.push_back({0, std::uint32_t(boxes.size()), 0});
  const auto centre = [&](std::uint32_t i) { return boxes[i].min + boxes[i].max; };
  for (std::size_t n = 0; n < tree.nodes.size(); ++n) {
    const SahNode node = tree.nodes[n];
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

TEST(Sah, BeatsMedianSplitsWhereThingsCluster) {
  Random random(6);
  std::vector<Aabb> boxes;
  for (int cluster = 0; cluster < 60; ++cluster) {
    const vec3 centre(uniform_float(random, -500, 500), uniform_float(random, -500, 500), uniform_float(random, 0, 50));
    const int members = 1 + int(random() % 400);
    for (int i = 0; i < members; ++i) {
      vec3 p = centre, q;
      for (int a = 0; a < 3; ++a) p[a] += uniform_float(random, -5, 5), q[a] = p[a] + uniform_float(random, 0.01, 0.5);
      boxes.push_back({p, q});
    }
  }
  EXPECT_LT(total_surface(build_sah(boxes), boxes), 0.9 * total_surface(median_tree(boxes), boxes));
}

}  // namespace
}  // namespace sightline::study::sah_test
