// The promises of the structures of apps/study/rays.
#include <algorithm>
#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "sightline/apps/study/rays/traversals.h"
#include "sightline/tests/study/rays_scenes.h"

namespace sightline::study::rays::structures_test {
namespace {

using core::Aabb;
using namespace tests;

static_assert(sizeof(KdNode) == 8 && sizeof(Bih::Node) == 12 && sizeof(Octree::Node) == 8 && sizeof(Bvh::Node) == 32);

constexpr std::uint64_t kSeed = 16;

class StructuresTest : public testing::TestWithParam<std::size_t> {
 protected:
  Random random_{kSeed};
  Mesh mesh_ = scenes(random_)[GetParam()];
  TriangleSet triangles_ = mesh_.set();
  Structures structures_{triangles_};
  std::vector<Aabb> boxes_ = triangles_.boxes();

  /// Inside, not only at the border.
  static bool overlap(const Aabb& a, const Aabb& b) {
    return glm::all(glm::lessThan(a.min, b.max)) && glm::all(glm::lessThan(b.min, a.max));
  }
  void expect_all_that_overlap(std::span<const std::uint32_t> ids, const Aabb& leaf) {
    const std::set<std::uint32_t> found(ids.begin(), ids.end());
    ASSERT_EQ(found.size(), ids.size()) << "a triangle twice";
    for (std::uint32_t i = 0; i < boxes_.size(); ++i)
      ASSERT_TRUE(!overlap(boxes_[i], leaf) || found.count(i) != 0) << mesh_.name << ": triangle " << i;
  }
  void expect_each_once(std::vector<std::uint32_t> ids) {
    std::sort(ids.begin(), ids.end());
    ASSERT_EQ(ids.size(), boxes_.size());
    for (std::uint32_t i = 0; i < ids.size(); ++i) ASSERT_EQ(ids[i], i);
  }
  void expect_shared_out(const SparseBoxGrid& grid) {
    std::size_t cells = 0;
    for (std::uint32_t b = 0; b < grid.boxes.size(); ++b) {
      const SparseBoxGrid::Box& box = grid.boxes[b];
      Aabb unit;
      for (int a = 0; a < 3; ++a) {
        ASSERT_LT(box.low[std::size_t(a)], box.high[std::size_t(a)]);
        unit.min[a] = grid.lines.line(a, box.low[std::size_t(a)]);
        unit.max[a] = grid.lines.line(a, box.high[std::size_t(a)]);
      }
      expect_all_that_overlap({grid.triangles.data() + box.first, box.count}, unit);
      Cell c;
      for (c[2] = box.low[2]; c[2] < box.high[2]; ++c[2])
        for (c[1] = box.low[1]; c[1] < box.high[1]; ++c[1])
          for (c[0] = box.low[0]; c[0] < box.high[0]; ++c[0], ++cells)
            ASSERT_EQ(grid.box_of_cell[grid.lines.index(c)], b);
    }
    EXPECT_EQ(cells, grid.lines.count());
  }
};

TEST_P(StructuresTest, LeavesOfKdTreesHaveAllThatOverlaps) {
  const std::vector<Aabb> boxes = node_boxes(structures_.kd);
  for (std::size_t i = 0; i < boxes.size(); ++i)
    if (const KdNode& n = structures_.kd.nodes[i]; n.is_leaf())
      expect_all_that_overlap(structures_.kd.triangles_of(n), boxes[i]);
}

TEST_P(StructuresTest, RopesLeadToTheOtherSideOfTheFace) {
  const std::vector<Aabb> boxes = node_boxes(structures_.kd);
  for (const auto& leaf : structures_.kd_ropes.leaves) {
    for (int face = 0; face < 6; ++face) {
      const int a = face % 3;
      const float plane = face < 3 ? leaf.box.min[a] : leaf.box.max[a];
      const std::uint32_t rope = leaf.ropes[std::size_t(face)];
      const float border = face < 3 ? boxes[0].min[a] : boxes[0].max[a];
      ASSERT_EQ(rope == core::kNone, plane == border);
      if (rope == core::kNone) continue;
      ASSERT_EQ(face < 3 ? boxes[rope].max[a] : boxes[rope].min[a], plane);
      for (const int other : {(a + 1) % 3, (a + 2) % 3}) {
        ASSERT_LE(boxes[rope].min[other], leaf.box.min[other]);
        ASSERT_GE(boxes[rope].max[other], leaf.box.max[other]);
      }
    }
  }
}

TEST_P(StructuresTest, ParentsKnowTheirChildren) {
  const KdTreeWithParents& kd = structures_.kd_parents;
  for (std::uint32_t i = 1; i < kd.parents.size(); ++i) {
    const KdNode& parent = kd.tree.nodes[kd.parents[i]];
    ASSERT_FALSE(parent.is_leaf());
    ASSERT_TRUE(parent.left() == i || parent.left() + 1 == i);
  }
}

TEST_P(StructuresTest, BoxesOfASparseBoxGridShareOutTheCells) {
  expect_shared_out(structures_.sbg);
}

TEST_P(StructuresTest, HierarchiesOfObjectsHaveEachOnce) {
  expect_each_once(structures_.bvh.triangles);
  expect_each_once(structures_.bih.triangles);
}

INSTANTIATE_TEST_SUITE_P(Scenes, StructuresTest, testing::Range(std::size_t(0), std::size_t(13)));

/// Centroids that no plane parts, and such that every split parts few.
TEST(BvhBuild, StaysShallowOnHardBoxes) {
  std::vector<Aabb> shells, shrinking;
  for (int i = 1; i <= 5000; ++i) shells.push_back({vec3(-float(i)), vec3(float(i))});
  for (int i = 0; i < 126; ++i) shrinking.insert(shrinking.end(), 20, {vec3(0.0f), vec3(std::ldexp(1.0f, -i))});
  for (const std::vector<Aabb>& boxes : {shells, shrinking}) {
    const Bvh bvh = build_bvh(boxes);
    std::vector<std::uint32_t> depth(bvh.nodes.size(), 0);
    for (std::uint32_t i = 0; i < bvh.nodes.size(); ++i) {  // children come after their parents
      const Bvh::Node& node = bvh.nodes[i];
      ASSERT_LT(depth[i], Bvh::kMaxDepth);
      Aabb inside;
      if (node.is_leaf()) {
        ASSERT_LE(node.count, 4u);
        for (std::uint32_t k = node.first; k < node.first + node.count; ++k) inside.grow(boxes[bvh.triangles[k]]);
      } else {
        depth[node.first] = depth[node.first + 1] = depth[i] + 1;
        inside.grow(bvh.nodes[node.first].box);
        inside.grow(bvh.nodes[node.first + 1].box);
      }
      ASSERT_EQ(node.box.min, inside.min);
      ASSERT_EQ(node.box.max, inside.max);
    }
  }
}

TEST(GridResolution, LiesBetweenOneAndThreeCubeRootsAlongTheShortestAxis) {
  const Aabb cube{vec3(0.0f), vec3(1.0f)}, slab{vec3(0.0f), vec3(1.0f, 1.0f, 0.5f)};
  EXPECT_EQ(grid_resolution(cube, 1000, 1.0), (Cell{10, 10, 10}));
  EXPECT_EQ(grid_resolution(cube, 1000, 3.0), (Cell{30, 30, 30}));
  EXPECT_EQ(grid_resolution(slab, 1000, 1.0), (Cell{20, 20, 10}));
  const Aabb sheet{vec3(0.0f), vec3(1.0f, 1.0f, 1e-5f)};
  const GridLines flat(sheet, grid_resolution(sheet, 1000, 3.0));
  EXPECT_LE(flat.count(), 27000u);
  EXPECT_GT(flat.count(), 10000u);
}

}  // namespace
}  // namespace sightline::study::rays::structures_test
