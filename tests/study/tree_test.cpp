// The study's hierarchies: structure, boxes, leaf rule, on random and degenerate boxes.
#include "sightline/apps/study/tree.h"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

#include "sightline/tests/culling/scenes.h"

namespace sightline::study::tree_test {
namespace {

constexpr unsigned kSeed = 7;

/// Walks by child rule, not by escape index, and checks everything that tree.h says.
void check(const Tree& tree, std::span<const core::Aabb> boxes, std::span<const std::uint8_t> kinds,
           std::uint32_t leaf_size) {
  std::vector<std::uint32_t> sorted = tree.order;
  std::sort(sorted.begin(), sorted.end());
  ASSERT_EQ(sorted.size(), boxes.size());
  for (std::uint32_t i = 0; i < sorted.size(); ++i) ASSERT_EQ(sorted[i], i);
  ASSERT_EQ(tree.nodes[0].first, 0u);
  ASSERT_EQ(tree.nodes[0].end, boxes.size());
  ASSERT_EQ(tree.nodes[0].escape, tree.nodes.size());
  std::size_t leaves = 0;
  std::uint32_t height = 0;
  for (std::uint32_t i = 0; i < tree.nodes.size(); ++i) {
    const TreeNode& node = tree.nodes[i];
    height = std::max(height, node.depth + 1);
    core::Aabb box;
    for (std::uint32_t k = node.first; k < node.end; ++k) box.grow(boxes[tree.order[k]]);
    ASSERT_EQ(box.min, node.box.min);
    ASSERT_EQ(box.max, node.box.max);
    if (tree.leaf(i)) {
      ++leaves;
      std::array<std::uint32_t, 8> counts{};
      for (std::uint32_t k = node.first; k < node.end; ++k)
        ASSERT_LE(++counts[kinds.empty() ? 0 : kinds[tree.order[k]]], leaf_size);
      continue;
    }
    const TreeNode& left = tree.nodes[i + 1];
    ASSERT_LT(left.escape, tree.nodes.size());
    const TreeNode& right = tree.nodes[left.escape];
    ASSERT_EQ(left.first, node.first);
    ASSERT_EQ(left.end, right.first);
    ASSERT_EQ(right.end, node.end);
    ASSERT_LT(left.first, left.end);
    ASSERT_LT(right.first, right.end);
    ASSERT_EQ(right.escape, node.escape);
    ASSERT_EQ(left.depth, node.depth + 1);
    ASSERT_EQ(right.depth, node.depth + 1);
  }
  EXPECT_EQ(leaves, tree.leaves);
  EXPECT_EQ(height, tree.height);
  EXPECT_EQ(tree.nodes.size(), 2 * leaves - 1);
}

TEST(StudyTree, HoldsItsRules) {
  tests::Random random(kSeed);
  for (int round = 0; round < 60; ++round) {
    SCOPED_TRACE("seed " + std::to_string(kSeed) + ", round " + std::to_string(round));
    auto boxes = tests::random_boxes(random, std::size_t(tests::whole(random, 1, 500)), 50.0);
    if (round % 5 == 0) std::fill(boxes.begin() + std::ptrdiff_t(boxes.size() / 2), boxes.end(), boxes[0]);
    std::vector<std::uint8_t> kinds;
    for (std::size_t i = 0; i < boxes.size(); ++i) kinds.push_back(std::uint8_t(tests::whole(random, 0, 3)));
    for (const Split split : {Split::kMean, Split::kMedian}) {
      for (const std::uint32_t leaf_size : {1u, 3u}) {
        check(build_tree(boxes, {}, split, leaf_size), boxes, {}, leaf_size);
        check(build_tree(boxes, kinds, split, leaf_size), boxes, kinds, leaf_size);
      }
    }
  }
}

TEST(StudyTree, IsEmptyForNoBoxes) {
  EXPECT_TRUE(build_tree({}, {}, Split::kMean).nodes.empty());
}

TEST(StudyTree, MedianHalves) {
  tests::Random random(kSeed);
  const auto boxes = tests::random_boxes(random, 4096, 50.0);
  EXPECT_EQ(build_tree(boxes, {}, Split::kMedian, 1).height, 13u);
  EXPECT_EQ(build_tree(boxes, {}, Split::kMedian, 2).leaves, 2048u);
}

}  // namespace
}  // namespace sightline::study::tree_test
