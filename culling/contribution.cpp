#include "sightline/culling/contribution.h"

#include "sightline/culling/internal/filter_slots.h"
#include "sightline/culling/internal/kernels.h"

namespace sightline::culling {

ContributionTest::ContributionTest(const core::View& view, const core::dvec3& origin, int width, int height)
    : view_(make_screen_view(view, origin, width, height, 0.0f)) {}

float ContributionTest::area(const core::Aabb& box) const {
  alignas(64) float found[kLanes];
  of_one_box(box, [&](const auto& boxes) { return kernels().areas(view_, boxes, found), 0u; });
  return found[0];
}

void ContributionTest::areas(const core::ItemBounds& bounds, const core::VisibleSet& in,
                             std::vector<SlotArea>& areas) const {
  areas.clear();
  alignas(64) float found[kLanes];
  for_each_group(bounds, in, [&](const SlotGroup& group, unsigned, bool) {
    kernels().areas(view_, group.coordinates, found);
    for (int i = 0; i < group.count; ++i)
      if (!bounds.vacant(group.slots[i])) areas.push_back({group.slots[i], found[i]});
  });
}

/// Bit i: box i of sixteen has that area or more.
unsigned ContributionTest::at_least(const float* const (&coordinates)[6], float threshold,
                                    float (&areas)[kLanes]) const {
  kernels().areas(view_, coordinates, areas);
  unsigned found = 0;
  for (int i = 0; i < kLanes; ++i) found |= unsigned(areas[i] >= threshold) << i;
  return found;
}

void ContributionTest::filter(const core::ItemBounds& bounds, const core::VisibleSet& in, float threshold,
                              core::VisibleSet& kept, SlotBits before, SlotBits exempt) const {
  thread_local SlotCollector collector;
  alignas(64) float areas[kLanes];
  for_each_group(bounds, in, [&](const SlotGroup& group, unsigned used, bool of_range) {
    unsigned bits = at_least(group.coordinates, kHysteresis * threshold, areas);
    for (unsigned small = bits & used; small != 0; small &= small - 1) {
      const int i = std::countr_zero(small);
      if (areas[i] < threshold && !contains(before, group.slots[i])) bits &= ~(1u << i);
    }
    for (int i = 0; i < group.count; ++i) {
      if (contains(exempt, group.slots[i])) bits |= 1u << i;
      if (bounds.vacant(group.slots[i])) bits &= ~(1u << i);
    }
    collector.add(group, bits & used, of_range);
  });
  collector.finish(kept);
  kept.generation = in.generation;
  kept.counters = in.counters;
}

void ContributionTest::filter_leaves(const Hierarchy& hierarchy, const core::VisibleSet& in, float threshold,
                                     core::VisibleSet& kept, SlotBits exempt) const {
  alignas(64) float areas[kLanes];
  culling::filter_leaves(hierarchy, in, kept, exempt,
                         [&](const auto& boxes) { return at_least(boxes, kHysteresis * threshold, areas); });
}

}  // namespace sightline::culling
