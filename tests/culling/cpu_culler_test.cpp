// What the production culler promises beside the set itself: little work, merged ranges, no allocation, layers.
#include "sightline/culling/frustum/cpu_culler.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdlib>
#include <new>
#include <thread>

#include <gtest/gtest.h>

#include "scenes.h"
#include "sightline/culling/frustum/hierarchy.h"
#include "sightline/culling/frustum/linear_culler.h"

namespace {
std::atomic<std::uint64_t> g_allocations{0};
}

// Not inlined: GCC would see malloc meet delete.
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++g_allocations;
  if (void* p = std::malloc(size)) return p;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* p) noexcept {
  std::free(p);
}
[[gnu::noinline]] void operator delete(void* p, std::size_t) noexcept {
  std::free(p);
}

namespace sightline::tests::cpu_culler_test {
namespace {

using core::Aabb;
using core::View;
using core::VisibleSet;

/// side^3 cubes of half size 0.2 at whole coordinates 0 … side - 1.
std::vector<Aabb> grid(int side) {
  std::vector<Aabb> boxes;
  for (int x = 0; x < side; ++x)
    for (int y = 0; y < side; ++y)
      for (int z = 0; z < side; ++z) boxes.push_back(box_around({x, y, z}, core::dvec3(0.2)));
  return boxes;
}

View around(double side) {
  return *View::orthographic({{side / 2, -2 * side, side / 2}, {side / 2, 0, side / 2}, {0, 0, 1}}, 3 * side, 1.0, 0.0,
                             9 * side);
}

View looking_away(double side) {
  return *View::perspective({{-2 * side, 0, 0}, {-9 * side, 0, 0}, {0, 0, 1}}, 1.0, 1.0, 0.1);
}

/// Sees a corner of the grid.
View partial(double side) {
  return *View::orthographic({{0, -side, 0}, {0, 0, 0}, {0, 0, 1}}, 1.1 * side, 1.0, 0.0, 1.4 * side);
}

TEST(CpuCuller, WhollyVisibleSceneIsOneRange) {
  const Scene scene(grid(20), core::dvec3(0.0));
  VisibleSet set;
  scene.culler->cull(around(20), set);
  ASSERT_EQ(set.ranges.size(), 1u);
  EXPECT_EQ(set.ranges[0], (core::SlotRange{0, 8000}));
  EXPECT_TRUE(set.single_slots.empty());
  EXPECT_LE(set.counters.nodes_tested, 16u);
  EXPECT_EQ(set.counters.boxes_tested, 0u);
}

TEST(CpuCuller, NothingVisibleCostsLittle) {
  const Scene scene(grid(20), core::dvec3(0.0));
  VisibleSet set;
  scene.culler->cull(looking_away(20), set);
  EXPECT_EQ(set.count(), 0u);
  EXPECT_LE(set.counters.nodes_tested, 16u);
  EXPECT_EQ(set.counters.boxes_tested, 0u);
}

TEST(CpuCuller, PartialViewTestsFarLessThanEverything) {
  const Scene scene(grid(40), core::dvec3(0.0));
  VisibleSet set, linear;
  scene.culler->cull(partial(40), set);
  culling::LinearCuller(scene.bounds).cull(partial(40), linear);
  EXPECT_EQ(linear.counters.boxes_tested, 64000u);
  EXPECT_EQ(linear.counters.nodes_tested, 0u);
  EXPECT_LT(set.counters.boxes_tested + set.counters.nodes_tested, 64000u / 2);
  EXPECT_GT(set.counters.nodes_tested, 16u);
  EXPECT_FALSE(set.ranges.empty());
  EXPECT_FALSE(set.single_slots.empty());
  EXPECT_EQ(set.sorted_slots(), linear.sorted_slots());
}

/// The walk, box by box.
struct PlainWalk {
  const culling::Hierarchy& tree;
  const culling::CullPlanes planes;
  int levels = 0;
  std::uint64_t nodes = 0, leaves = 0;

  void look_into(int level, std::uint32_t index, culling::PlaneMask mask) {
    constexpr std::uint32_t kLanes = culling::kLanes;
    levels = std::max(levels, tree.level_count() - level);
    ++nodes;
    const auto& b = tree.level(level)[index].bounds;
    for (std::uint32_t lane = index * kLanes; lane < std::min((index + 1) * kLanes, tree.lane_count(level)); ++lane) {
      const std::uint32_t i = lane % kLanes;
      const Aabb box{{b[0][i], b[1][i], b[2][i]}, {b[3][i], b[4][i], b[5][i]}};
      const culling::PlaneMask rest = planes.remaining(box, mask);
      if (planes.outside(box, mask) || rest == 0) continue;
      if (level > 0)
        look_into(level - 1, lane, rest);
      else
        ++leaves;
    }
  }
};

TEST(CpuCuller, CountsItsWalk) {
  bool into_leaves = false, above_them = false;
  for (const int side : {1, 3, 8, 20, 40}) {
    const Scene scene(grid(side), core::dvec3(0.0));
    const culling::Hierarchy& tree = scene.culler->hierarchy();
    for (const View& view : {partial(side), looking_away(side), partial(3.0 * side)}) {
      SCOPED_TRACE(testing::Message() << side << "^3 boxes");
      VisibleSet set;
      scene.culler->cull(view, set);
      if (set.counters.nodes_tested == 1) continue;  // all in view: no walk
      PlainWalk walk{tree, culling::CullPlanes(view, scene.bounds)};
      walk.look_into(tree.level_count() - 1, 0, walk.planes.all());
      EXPECT_EQ(set.counters.nodes_tested, 16 * walk.nodes);
      EXPECT_EQ(set.counters.boxes_tested, 32 * walk.leaves);
      into_leaves |= walk.leaves > 0;
      above_them |= walk.leaves == 0 && walk.levels < tree.level_count();
    }
  }
  EXPECT_TRUE(into_leaves && above_them);
}

TEST(CpuCuller, EmptyScene) {
  const Scene nothing(std::vector<Aabb>{}, core::dvec3(0.0));
  VisibleSet set;
  nothing.culler->cull(around(2), set);
  EXPECT_EQ(set.count(), 0u);
  EXPECT_EQ(nothing.culler->hierarchy().node_count(), 0u);
}

TEST(CpuCuller, GrowsWithTheBounds) {
  Scene scene(grid(5), core::dvec3(0.0));
  scene.bounds.resize(126);
  scene.culler->update({});
  VisibleSet set;
  scene.culler->cull(around(5), set);
  EXPECT_EQ(scene.occupied(set).size(), 125u) << "a new box is empty";
  scene.bounds.set(125, box_around(core::dvec3(2.5), core::dvec3(0.1)));
  scene.culler->update(std::array{core::Slot(125)});
  scene.culler->cull(around(5), set);
  EXPECT_EQ(scene.occupied(set).size(), 126u);
}

TEST(CpuCuller, VacantSlotsCutNoRangeAndAreNeverItems) {
  Scene scene(grid(8), core::dvec3(0.0));
  scene.bounds.set(100, Aabb{});
  scene.culler->refit();
  EXPECT_FALSE(scene.culler->hierarchy().uses_layers());
  VisibleSet set;
  scene.culler->cull(around(8), set);
  ASSERT_EQ(set.ranges.size(), 1u);
  EXPECT_EQ(set.ranges[0], (core::SlotRange{0, 512}));
  EXPECT_TRUE(set.single_slots.empty());
  EXPECT_EQ(scene.occupied(set).size(), 511u);
  // A view of everything there is: no plane at all.
  core::dmat4 everywhere(0.0);
  everywhere[3][3] = 1.0;
  const auto view = View::from_matrices(core::dmat4(1.0), everywhere, core::ClipDepth::kMinusOneToOne);
  scene.culler->cull(*view, set);
  EXPECT_EQ(scene.occupied(set).size(), 511u);
  culling::LinearCuller(scene.bounds).cull(*view, set);
  EXPECT_EQ(set.count(), 511u);
  // Every second one gone, and a view whose planes go through the rest.
  for (core::Slot i = 0; i < 512; i += 2) scene.bounds.set(i, Aabb{});
  scene.culler->refit();
  scene.culler->cull(partial(8), set);
  EXPECT_FALSE(set.single_slots.empty());
  for (const core::Slot slot : set.single_slots) EXPECT_FALSE(scene.bounds.vacant(slot));
}

TEST(CpuCuller, RefitFollowsMovedBoxes) {
  Scene scene(grid(8), core::dvec3(0.0));
  VisibleSet set;
  scene.culler->cull(looking_away(8), set);
  ASSERT_EQ(set.count(), 0u);
  scene.bounds.set(77, box_around({-30, 0, 0}, core::dvec3(0.5)));
  scene.culler->refit();
  scene.culler->cull(looking_away(8), set);
  EXPECT_EQ(set.sorted_slots(), std::vector<core::Slot>{77});
}

TEST(CpuCuller, LayersInTheHierarchy) {
  Scene scene(grid(10), core::dvec3(0.0));
  View view = around(10);
  VisibleSet set;
  view.layers = ~core::kLayerModel;
  scene.culler->cull(view, set);
  EXPECT_EQ(set.count(), 0u) << "all items are on the model layer";
  EXPECT_EQ(set.counters.nodes_tested, 0u);

  // Every item on a layer of its own choice, all of them in the mask: still one range.
  for (core::Slot i = 0; i < 1000; ++i) scene.bounds.set_layers(i, 1u << (i % 7));
  scene.culler->refit();
  view.layers = 0x7f;
  scene.culler->cull(view, set);
  EXPECT_EQ(set.ranges.size(), 1u);
  EXPECT_EQ(set.counters.boxes_tested, 0u);
  view.layers = 1u << 3;
  scene.culler->cull(view, set);
  EXPECT_EQ(set.count(), 143u);

  // One layer for a run of slots: subtrees outside it are not entered.
  for (core::Slot i = 0; i < 1000; ++i) scene.bounds.set_layers(i, i < 900 ? 1u : 2u);
  scene.culler->refit();
  view.layers = 2;
  scene.culler->cull(view, set);
  EXPECT_EQ(set.count(), 100u);
  EXPECT_LT(set.counters.boxes_tested, 200u);
  scene.bounds.set(950, Aabb{});
  scene.culler->refit();
  scene.culler->cull(view, set);
  EXPECT_EQ(scene.occupied(set).size(), 99u);
}

TEST(CpuCuller, SectionPlanes) {
  const Scene scene(grid(10), core::dvec3(0.0));
  View view = around(10);
  VisibleSet set;
  view.sections = {{{1, 0, 0}, -4.5}, {{0, 1, 0}, -4.5}};
  scene.culler->cull(view, set);
  EXPECT_EQ(set.count(), 250u);
  view.section_mode = core::SectionMode::kUnion;
  scene.culler->cull(view, set);
  EXPECT_EQ(set.count(), 750u);
  // Without a normal: no plane, in either mode.
  view.sections.push_back({{0, 0, 0}, -1.0});
  scene.culler->cull(view, set);
  EXPECT_EQ(set.count(), 750u);
  view.sections = {{{0, 0, 0}, -1.0}};
  scene.culler->cull(view, set);
  EXPECT_EQ(set.count(), 1000u);
  // Not finite: more is drawn, never less.
  view.sections = {{{1, 0, 0}, -4.5}, {{0, std::nan(""), 0}, 0.0}};
  scene.culler->cull(view, set);
  EXPECT_EQ(set.count(), 1000u) << "union";
  view.section_mode = core::SectionMode::kIntersection;
  scene.culler->cull(view, set);
  EXPECT_EQ(set.count(), 500u) << "intersection";
  // A plane that touches the boxes keeps them: 4.8 is the face of the row at 5, rounded outwards.
  view.sections = {{{1, 0, 0}, -double(scene.bounds.extent().max.x)}};
  scene.culler->cull(view, set);
  EXPECT_EQ(set.count(), 100u);
}

TEST(CpuCuller, DoesNotAllocateInSteadyState) {
  Scene scene(grid(30), core::dvec3(0.0));
  const View views[] = {around(30), partial(30), looking_away(30)};
  VisibleSet set;
  for (int pass = 0; pass < 2; ++pass)
    for (const View& view : views) scene.culler->cull(view, set), culling::LinearCuller(scene.bounds).cull(view, set);
  const std::uint64_t before = g_allocations;
  for (const View& view : views) scene.culler->cull(view, set), culling::LinearCuller(scene.bounds).cull(view, set);
  EXPECT_EQ(g_allocations, before);
}

TEST(CpuCuller, SeveralThreadsAtOnce) {
  const Scene scene(grid(20), core::dvec3(0.0));
  VisibleSet expected;
  scene.culler->cull(partial(20), expected);
  std::vector<VisibleSet> sets(4);
  std::vector<std::thread> threads;
  for (VisibleSet& set : sets)
    threads.emplace_back([&] {
      for (int i = 0; i < 20; ++i) scene.culler->cull(partial(20), set);
    });
  for (std::thread& thread : threads) thread.join();
  for (const VisibleSet& set : sets) {
    EXPECT_EQ(set.ranges, expected.ranges);
    EXPECT_EQ(set.single_slots, expected.single_slots);
  }
}

TEST(CpuCuller, SeveralViewsAreTheViewsOneByOne) {
  constexpr std::uint64_t kSeed = 7;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  Random random(kSeed);
  const Scene scene(random_boxes(random, 30'000, 50.0), core::dvec3(0.0));
  core::ThreadPool threads(3);
  for (int round = 0; round < 40; ++round) {
    std::vector<core::View> views;
    for (int i = whole(random, 0, 8); i > 0; --i) views.push_back(random_view(random, core::dvec3(0.0), 50.0));
    std::vector<core::VisibleSet> sets(views.size());
    for (core::ThreadPool* with : {static_cast<core::ThreadPool*>(nullptr), &threads}) {
      scene.culler->cull(views, sets, with);
      for (std::size_t i = 0; i < views.size(); ++i) {
        core::VisibleSet alone;
        scene.culler->cull(views[i], alone);
        ASSERT_EQ(sets[i].ranges, alone.ranges);
        ASSERT_EQ(sets[i].single_slots, alone.single_slots);
      }
    }
  }
}

}  // namespace
}  // namespace sightline::tests::cpu_culler_test
