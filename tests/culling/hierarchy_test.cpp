// Structure of the collapsed hierarchy: children in slot order, ranges complete, boxes around what lies below.
#include "sightline/culling/hierarchy.h"

#include <gtest/gtest.h>

#include "scenes.h"

namespace sightline::tests {
namespace {

using culling::ChildRef;
using culling::Hierarchy;
using culling::kLanes;

struct Visit {
  ChildRef node;
  std::uint32_t first, end, level;
};

/// Walks the whole tree and checks every lane.
void check(const Hierarchy& hierarchy, const core::ItemBounds& bounds, std::uint32_t largest_leaf) {
  std::vector<Visit> stack{{hierarchy.root(), 0, hierarchy.slot_count(), 1}};
  std::size_t nodes = 0;
  std::uint32_t depth = 0;
  while (!stack.empty()) {
    const Visit visit = stack.back();
    stack.pop_back();
    ++nodes;
    depth = std::max(depth, visit.level);
    ASSERT_FALSE(visit.node.is_leaf());
    const auto& node = hierarchy.node(visit.node.index());
    std::uint32_t next = visit.first;
    for (int i = 0; i < kLanes; ++i) {
      const std::uint32_t end = i + 1 < kLanes ? node.first[i + 1] : visit.end;
      if (i >= visit.node.lanes()) {
        ASSERT_TRUE(node.child[i].is_leaf());
        ASSERT_EQ(node.child[i].leaf_count(), 0u);
        ASSERT_GT(node.bounds[0][i], node.bounds[3][i]);
        continue;
      }
      ASSERT_EQ(node.first[i], next);
      ASSERT_GT(end, next);
      next = end;
      core::Aabb expected;
      for (std::uint32_t slot = node.first[i]; slot < end; ++slot) expected.grow(bounds.box(slot));
      for (int axis = 0; axis < 3; ++axis) {
        ASSERT_EQ(node.bounds[axis][i], expected.min[axis]);
        ASSERT_EQ(node.bounds[axis + 3][i], expected.max[axis]);
      }
      if (node.child[i].is_leaf()) {
        ASSERT_EQ(node.child[i].leaf_count(), end - node.first[i]);
        ASSERT_LE(node.child[i].leaf_count(), largest_leaf);
      } else {
        stack.push_back({node.child[i], node.first[i], end, visit.level + 1});
      }
    }
    ASSERT_EQ(next, visit.end);
  }
  EXPECT_EQ(nodes, hierarchy.node_count());
  EXPECT_EQ(depth, hierarchy.depth());
}

TEST(Hierarchy, StructureOnRandomScenes) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const auto boxes = random_boxes(random, std::size_t(magnitude(random, 1.0, 5000.0)), 100.0);
    core::BvhConfig config;
    config.max_leaf_size = std::uint32_t(whole(random, 1, 30));
    Scene scene(boxes, core::dvec3(0.0), 0, config);
    const Hierarchy& hierarchy = scene.culler->hierarchy();
    const std::uint32_t largest_leaf = std::max(config.max_leaf_size, std::uint32_t(kLanes));
    ASSERT_NO_FATAL_FAILURE(check(hierarchy, scene.bounds, largest_leaf));
    EXPECT_LE(hierarchy.depth(), scene.tree.depth + 1);
    for (std::size_t i = 0; i < boxes.size(); i += 3) scene.bounds.set(i, random_box(random, 500.0));
    scene.culler->refit();
    ASSERT_NO_FATAL_FAILURE(check(hierarchy, scene.bounds, largest_leaf));
  }
}

TEST(Hierarchy, NodesAreWellFilled) {
  Random random(3);
  const Scene scene(random_boxes(random, 50000, 100.0), core::dvec3(0.0));
  const double bytes_per_item = double(scene.culler->memory_bytes()) / 50000.0;
  EXPECT_LT(bytes_per_item, 20.0);
  EXPECT_EQ(scene.culler->memory_bytes() % 256, 0u);
}

TEST(Hierarchy, OneBox) {
  const std::vector<core::Aabb> boxes{box_around(core::dvec3(1.0), core::dvec3(0.5))};
  const Scene scene(boxes, core::dvec3(0.0));
  EXPECT_EQ(scene.culler->hierarchy().node_count(), 1u);
  EXPECT_EQ(scene.culler->hierarchy().depth(), 1u);
  ASSERT_NO_FATAL_FAILURE(check(scene.culler->hierarchy(), scene.bounds, 8));
}

}  // namespace
}  // namespace sightline::tests
