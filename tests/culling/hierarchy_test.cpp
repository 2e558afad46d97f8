// Structure of the hierarchy: every lane of every level holds exactly the box of its block of slots.
#include "sightline/culling/frustum/hierarchy.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "scenes.h"

namespace sightline::tests::hierarchy_test {
namespace {

using culling::Hierarchy;
using culling::kLanes;

/// Boxes of every block, by growing.
void check(const Hierarchy& hierarchy, const core::ItemBounds& bounds) {
  ASSERT_EQ(hierarchy.slot_count(), bounds.size());
  std::size_t block = culling::kLeafSize, nodes = 0;
  for (int level = 0; level < hierarchy.level_count(); ++level, block *= kLanes) {
    ASSERT_EQ(hierarchy.lane_count(level), (hierarchy.slot_count() + block - 1) / block);
    ASSERT_EQ(hierarchy.level(level).size(), (hierarchy.lane_count(level) + kLanes - 1) / kLanes);
    nodes += hierarchy.level(level).size();
    for (std::size_t lane = 0; lane < hierarchy.level(level).size() * kLanes; ++lane) {
      core::Aabb expected;
      const std::size_t end = std::min<std::size_t>(hierarchy.slot_count(), (lane + 1) * block);
      for (std::size_t slot = lane * block; slot < end; ++slot)
        if (!bounds.box(slot).empty()) expected.grow(bounds.box(slot));
      const auto& node = hierarchy.level(level)[lane / kLanes];
      for (int axis = 0; axis < 3; ++axis) {
        ASSERT_EQ(node.bounds[axis][lane % kLanes], expected.min[axis]) << "level " << level << " lane " << lane;
        ASSERT_EQ(node.bounds[axis + 3][lane % kLanes], expected.max[axis]) << "level " << level << " lane " << lane;
      }
    }
  }
  EXPECT_EQ(hierarchy.level(hierarchy.level_count() - 1).size(), 1u);
  EXPECT_EQ(hierarchy.node_count(), nodes);
}

TEST(Hierarchy, BoxesOfAllLevels) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    auto boxes = random_boxes(random, std::size_t(magnitude(random, 1.0, 10000.0)), 100.0);
    if (chance(random, 0.5)) spoil(random, boxes);
    Scene scene(boxes, core::dvec3(0.0));
    ASSERT_NO_FATAL_FAILURE(check(scene.culler->hierarchy(), scene.bounds));
    for_each_instruction_set([&] {
      for (std::size_t i = 0; i < boxes.size(); i += 3) scene.bounds.set(i, random_box(random, 500.0));
      scene.culler->refit();
      ASSERT_NO_FATAL_FAILURE(check(scene.culler->hierarchy(), scene.bounds));
    });
  }
}

TEST(Hierarchy, LayersOfAllLevels) {
  Random random(2);
  Scene scene(random_boxes(random, 20000, 100.0), core::dvec3(0.0));
  EXPECT_FALSE(scene.culler->hierarchy().uses_layers());
  for (std::size_t i = 0; i < 20000; ++i) scene.bounds.set_layers(i, std::uint32_t(whole(random, 1000, 3999) / 1000));
  for (std::size_t i = 7; i < 7000; i += 7) scene.bounds.set(i, core::Aabb{});
  for (std::size_t i = 9000; i < 12000; ++i) scene.bounds.set(i, core::Aabb{});
  scene.culler->refit();
  const Hierarchy& hierarchy = scene.culler->hierarchy();
  std::size_t block = culling::kLeafSize;
  for (int level = 0; level < hierarchy.level_count(); ++level, block *= kLanes) {
    for (std::size_t lane = 0; lane < hierarchy.lane_count(level); ++lane) {
      std::uint32_t any = 0, all = ~0u;
      for (std::size_t slot = lane * block; slot < std::min<std::size_t>(20000, (lane + 1) * block); ++slot) {
        if (scene.bounds.vacant(slot)) continue;
        any |= scene.bounds.layers(slot);
        all &= scene.bounds.layers(slot);
      }
      const auto& node = hierarchy.layers(level)[lane / kLanes];
      ASSERT_EQ(node.any[lane % kLanes], any);
      ASSERT_EQ(node.all[lane % kLanes], all);
    }
  }
}

/// Bit for bit what a new one would be.
void expect_equal(const Hierarchy& a, const Hierarchy& b) {
  ASSERT_EQ(a.slot_count(), b.slot_count());
  ASSERT_EQ(a.level_count(), b.level_count());
  ASSERT_EQ(a.uses_layers(), b.uses_layers());
  for (int level = 0; level < a.level_count(); ++level) {
    const auto nodes = std::as_bytes(a.level(level)), fresh = std::as_bytes(b.level(level));
    ASSERT_TRUE(std::ranges::equal(nodes, fresh)) << "boxes of level " << level;
    const auto layers = std::as_bytes(a.layers(level)), fresh_layers = std::as_bytes(b.layers(level));
    ASSERT_TRUE(std::ranges::equal(layers, fresh_layers)) << "layers of level " << level;
  }
}

/// `wide` errs, if at all, on the side of walking further.
void expect_around(const Hierarchy& wide, const Hierarchy& exact) {
  ASSERT_EQ(wide.level_count(), exact.level_count());
  ASSERT_EQ(wide.uses_layers(), exact.uses_layers());
  for (int level = 0; level < wide.level_count(); ++level) {
    for (std::uint32_t lane = 0; lane < wide.lane_count(level); ++lane) {
      const std::uint32_t node = lane / kLanes, i = lane % kLanes;
      const auto &w = wide.level(level)[node].bounds, &e = exact.level(level)[node].bounds;
      for (int axis = 0; axis < 3; ++axis)
        ASSERT_TRUE(w[axis][i] <= e[axis][i] && w[axis + 3][i] >= e[axis + 3][i]) << "level " << level << ", " << lane;
      if (!wide.uses_layers()) continue;
      const auto &wl = wide.layers(level)[node], &el = exact.layers(level)[node];
      ASSERT_EQ(el.any[i] & ~wl.any[i], 0u);
      ASSERT_EQ(wl.all[i] & ~el.all[i], 0u);
    }
  }
}

TEST(Hierarchy, UpdatesLikeANewOne) {
  core::ThreadPool threads(3);
  for (std::uint64_t seed = 1; seed <= 80; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const bool some_go = seed % 2 == 0;  // what becomes vacant leaves its surroundings as they are
    core::ItemBounds bounds;
    bounds.resize(seed % 5 == 0 ? 0 : std::size_t(magnitude(random, 1.0, 20000.0)));
    for (std::size_t i = 0; i < bounds.size(); ++i) bounds.set(i, random_box(random, 100.0));
    Hierarchy hierarchy(bounds);
    for (int round = 0; round < 8; ++round) {
      std::vector<core::Slot> changed;
      for (auto i = std::size_t(magnitude(random, 1.0, 1.0 + double(bounds.size()))); i > 0 && bounds.size() > 0; --i) {
        const core::Slot slot = core::Slot(whole(random, 0, int(bounds.size()) - 1));
        bounds.set(slot, some_go && chance(random, 0.2) ? core::Aabb{} : random_box(random, 200.0));
        if (round > 3 && chance(random, 0.3)) bounds.set_layers(slot, std::uint32_t(whole(random, 1, 7)));
        changed.push_back(slot);
      }
      const std::size_t old = bounds.size();
      if (chance(random, 0.5)) bounds.resize(old + std::size_t(magnitude(random, 1.0, 40000.0)));
      for (std::size_t i = old; i < bounds.size(); ++i)
        if (chance(random, 0.9)) bounds.set(i, random_box(random, 300.0));
      hierarchy.update(bounds, changed, seed % 3 == 0 ? &threads : nullptr);
      if (some_go)
        ASSERT_NO_FATAL_FAILURE(expect_around(hierarchy, Hierarchy(bounds))) << "round " << round;
      else
        ASSERT_NO_FATAL_FAILURE(expect_equal(hierarchy, Hierarchy(bounds))) << "round " << round;
    }
    bounds.resize(bounds.size() / 3);
    hierarchy.refit(bounds, seed % 3 == 0 ? &threads : nullptr);
    ASSERT_NO_FATAL_FAILURE(expect_equal(hierarchy, Hierarchy(bounds))) << "shrunk";
  }
}

/// A root that is full gets another one above it, which has its box to learn although nothing below has changed.
TEST(Hierarchy, GrowsFromExactlyFullLevels) {
  Random random(4);
  for (const std::size_t full : {culling::kLeafSize, 512u, 512u * 16u})
    for (const std::size_t more : {1u, 31u, 512u, 20'000u})
      for (const bool layers : {false, true}) {
        SCOPED_TRACE(testing::Message() << full << " + " << more << (layers ? " with layers" : ""));
        core::ItemBounds bounds;
        bounds.resize(full);
        for (std::size_t i = 0; i < full; ++i) bounds.set(i, random_box(random, 100.0));
        if (layers) bounds.set_layers(3, 2);
        Hierarchy hierarchy(bounds);
        bounds.resize(full + more);
        for (std::size_t i = full; i < full + more; ++i) bounds.set(i, random_box(random, 100.0));
        hierarchy.update(bounds, {});
        ASSERT_NO_FATAL_FAILURE(expect_equal(hierarchy, Hierarchy(bounds)));
      }
}

TEST(Hierarchy, TakesLessThanOneByteAndAHalfPerItem) {
  Random random(3);
  const Scene scene(random_boxes(random, 50000, 100.0), core::dvec3(0.0));
  EXPECT_LT(double(scene.culler->memory_bytes()), 1.5 * 50000.0);
}

}  // namespace
}  // namespace sightline::tests::hierarchy_test
