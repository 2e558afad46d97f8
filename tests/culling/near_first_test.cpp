// Parts of a set from near to far: nothing is lost, and no part begins before an earlier one's last node.
#include "sightline/culling/occlusion/internal/near_first.h"

#include <algorithm>
#include <limits>

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
        if (chance(random, 0.1)) set.items.push_back(single);
    s += length;
  }
  return set;
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

    const auto distance_of = [&](std::uint32_t node) {
      core::Aabb around;
      for (std::size_t s = node * kNodeSlots; s < std::min<std::size_t>(count, (node + 1) * kNodeSlots); ++s)
        if (!bounds.vacant(s)) around.grow(bounds.box(s));
      return around.empty() ? std::numeric_limits<float>::quiet_NaN() : test.distance(around);
    };
    std::vector<Slot> all;
    float reached = -std::numeric_limits<float>::infinity();
    for (const VisibleSet& part : near_first.parts()) {
      ASSERT_EQ(part.generation, set.generation);
      const std::vector<Slot> slots = part.sorted_slots();
      ASSERT_FALSE(slots.empty());
      ASSERT_TRUE(std::is_sorted(part.items.begin(), part.items.end()));
      all.insert(all.end(), slots.begin(), slots.end());
      float farthest = reached;
      for (std::uint32_t node = 0; node * kNodeSlots < count && hierarchy.level_count() > 1; ++node) {
        const auto first = std::lower_bound(slots.begin(), slots.end(), node * kNodeSlots);
        if (first == slots.end() || *first >= (node + 1) * kNodeSlots) continue;
        const float distance = distance_of(node);
        ASSERT_FALSE(distance < reached) << "node " << node;
        farthest = std::max(farthest, distance);
      }
      reached = farthest;
    }
    std::sort(all.begin(), all.end());
    ASSERT_EQ(all, set.sorted_slots());
  }
  EXPECT_GT(most_parts, 8u);
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
