// Parts of a set from near to far, against parts made of the sorted nodes one by one.
#include "sightline/culling/occlusion/internal/near_first.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include <gtest/gtest.h>

#include "scenes.h"

namespace sightline::tests::near_first_test {
namespace {

using core::Slot;
using core::View;
using core::VisibleSet;

constexpr std::uint32_t kNodeSlots = culling::kLeafSize * culling::kLanes;

/// Some ranges of all lengths, some single slots between them.
VisibleSet random_set(Random& random, std::uint32_t count) {
  VisibleSet set;
  set.generation = 7;
  for (Slot s = 0; s < count;) {
    const std::uint32_t length = std::min<std::uint32_t>(count - s, std::uint32_t(whole(random, 1, 900)));
    if (chance(random, 0.5))
      set.ranges.push_back({s, length});
    else
      for (Slot single = s; single < s + length; ++single)
        if (chance(random, 0.1)) set.single_slots.push_back(single);
    s += length;
  }
  return set;
}

/// The least distance of a node of sixteen leaves; infinite where that is no number.
float distance_of(const core::ItemBounds& bounds, std::uint32_t node, const culling::OcclusionTest& test) {
  core::Aabb around;
  for (std::size_t s = node * kNodeSlots; s < std::min<std::size_t>(bounds.size(), (node + 1) * kNodeSlots); ++s)
    if (!bounds.vacant(s)) around.grow(bounds.box(s));
  const float distance = around.empty() ? std::numeric_limits<float>::quiet_NaN() : test.distance(around);
  return std::isnan(distance) ? std::numeric_limits<float>::infinity() : distance;
}

/// The obvious way: nodes in order, the nearest first. The first part gets a hundredth of the slots, or as many more as
/// its last node has, and each next one 1.3 times as large a share.
std::vector<std::vector<Slot>> expected_parts(const VisibleSet& set, const core::ItemBounds& bounds, bool one_node,
                                              const culling::OcclusionTest& test) {
  std::map<std::uint32_t, std::vector<Slot>> of_nodes;
  for (const Slot s : set.sorted_slots()) of_nodes[s / kNodeSlots].push_back(s);
  std::vector<std::pair<float, std::uint32_t>> order;
  for (const auto& [node, slots] : of_nodes)
    order.emplace_back(one_node ? 0.0f : distance_of(bounds, node, test), node);
  std::sort(order.begin(), order.end());
  std::vector<std::vector<Slot>> parts;
  double share = 0.01 * double(set.count()), end = 0.0, done = 0.0;
  for (const auto& [distance, node] : order) {
    if (parts.empty() || done >= end) {
      if (!parts.empty()) share *= 1.3;
      end = done + share;
      parts.emplace_back();
    }
    parts.back().insert(parts.back().end(), of_nodes[node].begin(), of_nodes[node].end());
    done += double(of_nodes[node].size());
  }
  for (std::vector<Slot>& part : parts) std::sort(part.begin(), part.end());
  return parts;
}

TEST(NearFirst, PartsAreTheSetFromNearToFar) {
  std::size_t most_parts = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const std::size_t count = std::size_t(whole(random, 1, seed % 3 == 0 ? 60'000 : 3'000));
    const auto boxes = random_boxes(random, count, 10.0);
    const auto order = core::block_order(boxes);
    core::ItemBounds bounds;
    bounds.resize(count);
    // Whole nodes are vacant.
    for (std::size_t i = 0; i < count; ++i)
      if (i / kNodeSlots % 7 != 3) bounds.set(i, boxes[order[i]]);
    const culling::Hierarchy hierarchy(bounds);
    const View view = random_view(random, core::dvec3(0.0), 10.0);
    culling::DepthPyramid pyramid;
    pyramid.clear(8, 8);
    const culling::OcclusionTest test(view, core::dvec3(0.0), 8, 8, pyramid);
    const VisibleSet set = random_set(random, std::uint32_t(count));
    culling::NearFirst near_first;
    near_first.split(random_set(random, std::uint32_t(count)), hierarchy, test);  // leaves nothing behind
    near_first.split(set, hierarchy, test);
    most_parts = std::max(most_parts, near_first.parts().size());

    const auto expected = expected_parts(set, bounds, hierarchy.level_count() == 1, test);
    ASSERT_EQ(near_first.parts().size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
      const VisibleSet& part = near_first.parts()[i];
      ASSERT_EQ(part.generation, set.generation);
      ASSERT_TRUE(std::is_sorted(part.single_slots.begin(), part.single_slots.end()));
      ASSERT_EQ(part.sorted_slots(), expected[i]) << "part " << i;
    }
  }
  EXPECT_GT(most_parts, 8u);
}

/// A hundredth of the slots is one node, or a little more or less.
TEST(NearFirst, PartsEndWhereTheirSharesDo) {
  const std::size_t count = 120 * kNodeSlots;
  core::ItemBounds bounds;
  bounds.resize(count);
  for (std::size_t i = 0; i < count; ++i)
    bounds.set(i, {{0, float(i / kNodeSlots), 0}, {1, float(i / kNodeSlots) + 0.5f, 1}});
  const culling::Hierarchy hierarchy(bounds);
  culling::DepthPyramid pyramid;
  pyramid.clear(8, 8);
  const View view = *View::perspective({{0, -10, 0}, {0, 0, 0}, {0, 0, 1}}, 0.6, 1.0, 0.1);
  const culling::OcclusionTest test(view, core::dvec3(0.0), 8, 8, pyramid);
  culling::NearFirst near_first;
  for (const std::uint32_t nodes : {1u, 99u, 100u, 101u})
    for (const std::uint32_t more : {0u, 1u, 2u, kNodeSlots - 1}) {
      SCOPED_TRACE(testing::Message() << nodes << " nodes and " << more << " slots");
      VisibleSet set;
      set.ranges = {{0, nodes * kNodeSlots + more}};
      near_first.split(set, hierarchy, test);
      const auto expected = expected_parts(set, bounds, false, test);
      ASSERT_EQ(near_first.parts().size(), expected.size());
      for (std::size_t i = 0; i < expected.size(); ++i) ASSERT_EQ(near_first.parts()[i].sorted_slots(), expected[i]);
    }
}

TEST(NearFirst, HasNoPartsOfNothing) {
  core::ItemBounds bounds;
  bounds.resize(3);
  const culling::Hierarchy hierarchy(bounds);
  culling::DepthPyramid pyramid;
  pyramid.clear(1, 1);
  const View view = *View::perspective({{0, -10, 0}, {0, 0, 0}, {0, 0, 1}}, 0.6, 1.0, 0.1);
  culling::NearFirst near_first;
  near_first.split({}, hierarchy, culling::OcclusionTest(view, core::dvec3(0.0), 1, 1, pyramid));
  EXPECT_TRUE(near_first.parts().empty());
}

}  // namespace
}  // namespace sightline::tests::near_first_test
