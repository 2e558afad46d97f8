// The hierarchy answers what the linear culler answers, slot by slot, whatever the scene.
#include <gtest/gtest.h>

#include "scenes.h"
#include "sightline/core/visible_set.h"
#include "sightline/culling/frustum/linear_culler.h"

namespace sightline::tests::culler_equality_test {
namespace {

using core::Aabb;
using core::View;

/// Lists in rising order, disjoint and merged.
void expect_well_formed(const core::VisibleSet& set) {
  ASSERT_EQ(std::adjacent_find(set.single_slots.begin(), set.single_slots.end(), std::greater_equal<>()),
            set.single_slots.end());
  for (std::size_t i = 0; i < set.ranges.size(); ++i) {
    ASSERT_GT(set.ranges[i].count, 0u);
    if (i > 0) {
      ASSERT_LT(set.ranges[i - 1].first + set.ranges[i - 1].count, set.ranges[i].first);
    }
  }
  const auto slots = set.sorted_slots();
  ASSERT_EQ(std::adjacent_find(slots.begin(), slots.end()), slots.end()) << "a slot is in both lists";
}

/// Also that the lists are well formed, and the same in every form of the kernels.
void expect_same(const Scene& scene, const View& view, core::VisibleSet& set) {
  std::vector<core::VisibleSet> trees, linears;
  for_each_instruction_set([&] {
    scene.culler->cull(view, set);
    trees.push_back(set);
    culling::LinearCuller(scene.bounds).cull(view, set);
    linears.push_back(set);
  });
  set = trees[0];
  for (std::size_t i = 1; i < trees.size(); ++i) {
    ASSERT_EQ(trees[i].ranges, trees[0].ranges);
    ASSERT_EQ(trees[i].single_slots, trees[0].single_slots);
    ASSERT_EQ(trees[i].counters.nodes_tested, trees[0].counters.nodes_tested);
    ASSERT_EQ(trees[i].counters.boxes_tested, trees[0].counters.boxes_tested);
    ASSERT_EQ(linears[i].single_slots, linears[0].single_slots);
    ASSERT_EQ(linears[i].ranges, linears[0].ranges);
  }
  ASSERT_EQ(scene.occupied(set), linears[0].sorted_slots());
  ASSERT_TRUE(std::none_of(set.single_slots.begin(), set.single_slots.end(),
                           [&](auto slot) { return scene.bounds.vacant(slot); }));
  ASSERT_NO_FATAL_FAILURE(expect_well_formed(set));
  ASSERT_NO_FATAL_FAILURE(expect_well_formed(linears[0]));
}

void set_random_layers(Random& random, core::ItemBounds& bounds) {
  const int kinds = whole(random, 1, 4);
  for (std::size_t i = 0; i < bounds.size(); ++i)
    if (chance(random, 0.5)) bounds.set_layers(i, std::uint32_t(whole(random, 1, (1 << kinds) - 1)));
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
    const core::BlockOrderOptions config{std::uint32_t(whole(random, 1, 40))};
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

/// Small boxes in a wide space: most nodes and leaves are crossed by one plane alone. Layers change from run to run.
TEST(CullerEquality, WideScenesInLayers) {
  core::VisibleSet set;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    std::vector<Aabb> boxes(20'000);
    for (Aabb& box : boxes) {
      const core::vec3 at(point(random, 100.0));
      box = {at, at + core::vec3(float(uniform(random, 0.0, 0.3)))};
    }
    Scene scene(boxes, core::dvec3(0.0));
    const std::size_t run = std::size_t(whole(random, 1, 3000));
    for (std::size_t i = 0; i < scene.bounds.size(); ++i)
      if (i / run % 3 != 0) scene.bounds.set_layers(i, 1u << (i / run % 3));
    scene.culler->refit();
    for (int v = 0; v < 25; ++v) {
      View view = random_view(random, core::dvec3(0.0), 100.0);
      view.layers = std::uint32_t(whole(random, 1, 7));
      ASSERT_NO_FATAL_FAILURE(expect_same(scene, view, set)) << "view " << v;
    }
  }
}

/// Any matrices that an application may hand in, including senseless ones.
TEST(CullerEquality, ForeignMatrices) {
  core::VisibleSet set;
  int taken = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const Scene scene(random_boxes(random, 300, 10.0), chance(random, 0.5) ? core::dvec3(0.0) : point(random, 1e7));
    const double scale = magnitude(random, 1e-300, 1e300);
    core::dmat4 clip(0.0);
    for (int c = 0; c < 4; ++c)
      for (int r = 0; r < 4; ++r)
        if (chance(random, 0.7)) clip[c][r] = uniform(random, -1.0, 1.0) * (c == 3 ? 10.0 : 1.0) * scale;
    const auto depth = core::ClipDepth(whole(random, 0, 2));
    const auto view = View::from_matrices(core::dmat4(1.0), clip, depth);
    if (!view) continue;  // a camera of another depth, by chance
    ++taken;
    ASSERT_NO_FATAL_FAILURE(expect_same(scene, *view, set));
  }
  EXPECT_GT(taken, 290);
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

/// The order decides how fast, never what. Sizes around every boundary of blocks.
TEST(CullerEquality, AnyOrderAndEverySize) {
  core::VisibleSet set;
  for (const int size : {1, 15, 16, 17, 31, 32, 33, 511, 512, 513, 8191, 8192, 8193, 131071, 131072, 131073}) {
    SCOPED_TRACE(size);
    Random random(std::uint64_t(size) + 1);
    Scene scene(random_boxes(random, std::size_t(size), 10.0), core::dvec3(0.0), std::size_t(size));
    for (int v = 0; v < (size > 10000 ? 5 : 40); ++v)
      ASSERT_NO_FATAL_FAILURE(expect_same(scene, random_view(random, core::dvec3(0.0), 10.0), set)) << "view " << v;
  }
}

/// More ranges and items than the kernels' buffers hold.
TEST(CullerEquality, ManyShortRanges) {
  std::vector<Aabb> boxes;
  for (int leaf = 0; leaf < 20000; ++leaf)
    for (int i = 0; i < 32; ++i)
      boxes.push_back(box_around({leaf % 2 == 0 ? 0.0 : i % 2 == 0 ? 2.0 : -0.99, leaf, i}, core::dvec3(0.1)));
  Scene scene(boxes, core::dvec3(0.0), boxes.size());
  View view = *View::orthographic({{0, 0, 0}, {0, 1, 0}, {0, 0, 1}}, 1e6, 1.0, -1e6, 1e6);
  view.sections = {{{1, 0, 0}, 1.0}, {{-1, 0, 0}, 1.0}};
  core::VisibleSet set;
  ASSERT_NO_FATAL_FAILURE(expect_same(scene, view, set));
  EXPECT_EQ(set.ranges.size(), 10000u);
  EXPECT_EQ(set.single_slots.size(), 160000u);
}

}  // namespace
}  // namespace sightline::tests::culler_equality_test
