// Structure of the hierarchy: every lane of every level holds exactly the box of its block of slots.
#include "sightline/culling/hierarchy.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "scenes.h"

namespace sightline::tests {
namespace {

using culling::Hierarchy;
using culling::kLanes;

void check(const Hierarchy& hierarchy, const core::ItemBounds& bounds) {
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
  for (std::size_t i = 0; i < 20000; ++i) scene.bounds.set_layers(i, std::uint32_t(whole(random, 0, 3000) / 1000));
  scene.bounds.set(7, core::Aabb{});
  scene.culler->refit();
  const Hierarchy& hierarchy = scene.culler->hierarchy();
  std::size_t block = culling::kLeafSize;
  for (int level = 0; level < hierarchy.level_count(); ++level, block *= kLanes) {
    for (std::size_t lane = 0; lane < hierarchy.lane_count(level); ++lane) {
      std::uint32_t any = 0, all = ~0u;
      bool hidden = false;
      for (std::size_t slot = lane * block; slot < std::min<std::size_t>(20000, (lane + 1) * block); ++slot) {
        const std::uint32_t own = scene.bounds.box(slot).empty() ? 0 : scene.bounds.layers(slot);
        any |= own;
        all &= own;
        hidden |= own == 0;
      }
      const auto& node = hierarchy.layers(level)[lane / kLanes];
      ASSERT_EQ(node.any[lane % kLanes], any);
      ASSERT_EQ(node.all[lane % kLanes], all);
      ASSERT_EQ((node.some_hidden >> lane % kLanes & 1) != 0, hidden);
    }
  }
}

TEST(Hierarchy, TakesLessThanOneByteAndAHalfPerItem) {
  Random random(3);
  const Scene scene(random_boxes(random, 50000, 100.0), core::dvec3(0.0));
  EXPECT_LT(double(scene.culler->memory_bytes()), 1.5 * 50000.0);
}

}  // namespace
}  // namespace sightline::tests
