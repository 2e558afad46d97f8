// The hierarchy answers what the linear culler answers, slot by slot, whatever the scene.
#include <gtest/gtest.h>

#include "scenes.h"
#include "sightline/core/visible_set.h"
#include "sightline/culling/linear_culler.h"

namespace sightline::tests {
namespace {

using core::Aabb;
using core::View;

/// Also that the lists are in rising order, disjoint and merged.
void expect_same(const Scene& scene, const View& view, core::VisibleSet& set) {
  scene.culler->cull(view, set);
  core::VisibleSet linear;
  culling::LinearCuller(scene.bounds).cull(view, linear);
  ASSERT_TRUE(linear.ranges.empty());
  ASSERT_TRUE(std::is_sorted(linear.items.begin(), linear.items.end()));
  ASSERT_EQ(set.count(), linear.items.size());
  ASSERT_EQ(set.sorted_slots(), linear.items);
  ASSERT_EQ(std::adjacent_find(set.items.begin(), set.items.end(), std::greater_equal<>()), set.items.end());
  for (std::size_t i = 0; i < set.ranges.size(); ++i) {
    ASSERT_GT(set.ranges[i].count, 0u);
    if (i > 0) {
      ASSERT_LT(set.ranges[i - 1].first + set.ranges[i - 1].count, set.ranges[i].first);
    }
  }
}

void set_random_layers(Random& random, core::ItemBounds& bounds) {
  const int kinds = whole(random, 1, 4);
  for (std::size_t i = 0; i < bounds.size(); ++i)
    if (chance(random, 0.5)) bounds.set_layers(i, std::uint32_t(whole(random, 0, (1 << kinds) - 1)));
}

TEST(CullerEquality, RandomScenesAndViews) {
  core::VisibleSet set;
  for (std::uint64_t seed = 1; seed <= 160; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const double half = magnitude(random, 1e-3, 1e5);
    const core::dvec3 origin = chance(random, 0.5) ? core::dvec3(0.0) : point(random, 1e7);
    auto boxes = random_boxes(random, std::size_t(magnitude(random, 1.0, 4000.0)), half);
    if (chance(random, 0.4)) spoil(random, boxes);
    core::BvhConfig config;
    config.max_leaf_size = std::uint32_t(whole(random, 1, 40));
    Scene scene(boxes, origin, chance(random, 0.5) ? boxes.size() / 7 : 0, config);
    if (chance(random, 0.5)) set_random_layers(random, scene.bounds);
    scene.culler->refit();
    for (int v = 0; v < 25; ++v) {
      View view = random_view(random, origin, half);
      if (chance(random, 0.4)) add_sections(random, origin, half, view);
      if (chance(random, 0.4)) view.layers = std::uint32_t(whole(random, 0, 15));
      ASSERT_NO_FATAL_FAILURE(expect_same(scene, view, set)) << "view " << v;
    }
    // Edits: boxes move, empty, return; layers change.
    for (std::size_t i = 0; i < scene.bounds.size(); ++i) {
      if (chance(random, 0.1)) scene.bounds.set(i, random_box(random, 3.0 * half));
      if (chance(random, 0.02)) scene.bounds.set(i, Aabb{});
      if (chance(random, 0.01)) scene.bounds.set_layers(i, 2);
    }
    scene.culler->refit();
    for (int v = 0; v < 10; ++v)
      ASSERT_NO_FATAL_FAILURE(expect_same(scene, random_view(random, origin, half), set)) << "edited, view " << v;
  }
}

/// Any matrices that an application may hand in, including senseless ones.
TEST(CullerEquality, ForeignMatrices) {
  core::VisibleSet set;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const Scene scene(random_boxes(random, 300, 10.0), chance(random, 0.5) ? core::dvec3(0.0) : point(random, 1e7));
    const double scale = magnitude(random, 1e-300, 1e300);
    core::dmat4 clip(0.0);
    for (int c = 0; c < 4; ++c)
      for (int r = 0; r < 4; ++r)
        if (chance(random, 0.7)) clip[c][r] = uniform(random, -1.0, 1.0) * (c == 3 ? 10.0 : 1.0) * scale;
    const auto depth = chance(random, 0.5) ? core::ClipDepth::kMinusOneToOne : core::ClipDepth::kReversedZeroToOne;
    const auto view = View::from_matrices(core::dmat4(1.0), clip, depth);
    ASSERT_TRUE(view);
    ASSERT_NO_FATAL_FAILURE(expect_same(scene, *view, set));
  }
}

TEST(CullerEquality, CoordinatesThatAreNotFinite) {
  core::VisibleSet set;
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    Scene scene(random_boxes(random, 500, 10.0), core::dvec3(0.0));
    // An infinite box makes the extent infinite and everything visible; NaN alone leaves the planes sharp.
    const bool infinite = chance(random, 0.3);
    for (core::Slot i = 0; i < 500; i += 50) {
      Aabb box = scene.bounds.box(i);
      const float value = !infinite ? nan : chance(random, 0.5) ? infinity : -infinity;
      const int axis = whole(random, 0, 2);
      (chance(random, 0.5) ? box.min : box.max)[axis] = value;
      scene.bounds.set(i, box);
    }
    Aabb all_nan;
    all_nan.min = all_nan.max = core::vec3(nan);
    scene.bounds.set(7, all_nan);
    scene.culler->refit();
    for (int v = 0; v < 20; ++v) {
      ASSERT_NO_FATAL_FAILURE(expect_same(scene, random_view(random, core::dvec3(0.0), 10.0), set));
      const auto slots = set.sorted_slots();
      ASSERT_TRUE(std::binary_search(slots.begin(), slots.end(), 7u)) << "a box of NaN must be drawn";
    }
  }
}

// --- stiff input -----------------------------------------------------------------------------------------------------

View overview(double distance) {
  return *View::perspective({{distance, -distance, distance}, {0, 0, 0}, {0, 0, 1}}, 0.6, 1.5, 0.01 * distance);
}

TEST(CullerEquality, CoincidentCentroids) {
  Random random(5);
  std::vector<Aabb> boxes;
  for (int i = 0; i < 3000; ++i)
    boxes.push_back(box_around(core::dvec3(0.0), core::dvec3(magnitude(random, 1e-3, 50))));
  const Scene scene(boxes, core::dvec3(0.0));
  core::VisibleSet set;
  for (int v = 0; v < 50; ++v)
    ASSERT_NO_FATAL_FAILURE(expect_same(scene, random_view(random, core::dvec3(0.0), 40.0), set));
}

TEST(CullerEquality, GiantAmongDust) {
  Random random(6);
  for (const double size : {1e4, 1e8, 1e20, 1e38}) {
    std::vector<Aabb> boxes;
    for (int i = 0; i < 5000; ++i) boxes.push_back(box_around(point(random, 1.0), core::dvec3(1e-4)));
    boxes[2500] = box_around(core::dvec3(0.0), core::dvec3(size));
    const Scene scene(boxes, core::dvec3(0.0));
    core::VisibleSet set;
    for (int v = 0; v < 50; ++v)
      ASSERT_NO_FATAL_FAILURE(expect_same(scene, random_view(random, core::dvec3(0.0), 1.0), set)) << size;
  }
}

TEST(CullerEquality, AMillionIdenticalBoxes) {
  const std::vector<Aabb> boxes(1000000, box_around(core::dvec3(1.0), core::dvec3(0.5)));
  const Scene scene(boxes, core::dvec3(0.0));
  EXPECT_LE(scene.culler->hierarchy().depth(), scene.tree.depth + 1);
  core::VisibleSet set;
  ASSERT_NO_FATAL_FAILURE(expect_same(scene, overview(10.0), set));
  EXPECT_EQ(set.count(), boxes.size());
  // The near plane through the boxes: each must be tested.
  const View close = *View::perspective({{1, 1, 1}, {1, 5, 1}, {0, 0, 1}}, 1.0, 1.0, 0.1);
  ASSERT_NO_FATAL_FAILURE(expect_same(scene, close, set));
  EXPECT_EQ(set.count(), boxes.size());
  const View away = *View::perspective({{9, 9, 9}, {20, 20, 20}, {0, 0, 1}}, 1.0, 1.0, 0.1);
  ASSERT_NO_FATAL_FAILURE(expect_same(scene, away, set));
  EXPECT_EQ(set.count(), 0u);
}

/// A tree of another maker: one slot split off at each level, deeper than the culler's own stack.
TEST(CullerEquality, DegenerateForeignTree) {
  constexpr std::uint32_t kCount = 3000;
  Random random(8);
  const auto boxes = random_boxes(random, kCount, 10.0);
  core::ItemBounds bounds;
  bounds.resize(kCount);
  for (std::uint32_t i = 0; i < kCount; ++i) bounds.set(i, boxes[i]);
  core::BvhTree tree;
  tree.nodes.push_back({0, kCount, 0});
  for (std::uint32_t i = 0, parent = 0; i + 9 < kCount; ++i) {
    const std::uint32_t left = std::uint32_t(tree.nodes.size());
    tree.nodes[parent].left = left;
    tree.nodes.push_back({i, 1, 0});
    tree.nodes.push_back({i + 1, kCount - i - 1, 0});
    parent = left + 1;
  }
  const culling::CpuCuller culler(bounds, tree, kCount);
  EXPECT_GT(culler.hierarchy().depth(), 200u);
  core::VisibleSet set, linear;
  for (int v = 0; v < 100; ++v) {
    const View view = random_view(random, core::dvec3(0.0), 10.0);
    culler.cull(view, set);
    culling::LinearCuller(bounds).cull(view, linear);
    ASSERT_EQ(set.sorted_slots(), linear.items) << "view " << v;
  }
}

}  // namespace
}  // namespace sightline::tests
