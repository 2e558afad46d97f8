#include "sightline/culling/occlusion/contribution.h"

#include <algorithm>
#include <bit>

#include "sightline/core/internal/scratch.h"
#include "sightline/culling/occlusion/internal/filter_slots.h"
#include "sightline/culling/occlusion/internal/kernels.h"

namespace sightline::culling {
namespace {

/// The solids of sixteen slots side by side.
class SolidLanes {
 public:
  explicit SolidLanes(std::span<const float> solids) : solids_(solids) {}

  /// Null when there are none. Borrowed until the next call.
  const float* of(const SlotGroup& group, bool of_range) {
    if (solids_.empty()) return nullptr;
    if (of_range && group.slots[0] + std::size_t(kLanes) <= solids_.size()) return solids_.data() + group.slots[0];
    for (int i = 0; i < group.count; ++i)
      copy_[i] = group.slots[i] < solids_.size() ? solids_[group.slots[i]] : std::numeric_limits<float>::infinity();
    return copy_;
  }

 private:
  std::span<const float> solids_;
  alignas(64) float copy_[kLanes] = {};
};

/// Bits of the slots of a group.
unsigned bits_of(const SlotGroup& group, SlotBits bits) {
  unsigned found = 0;
  for (int i = 0; i < group.count; ++i) found |= unsigned(contains(bits, group.slots[i])) << i;
  return found;
}

}  // namespace

ContributionTest::ContributionTest(const core::View& view, const core::dvec3& origin, int width, int height,
                                   std::span<const float> solids)
    : view_(make_screen_view(view, origin, width, height, 0.0f)), solids_(solids) {}

float ContributionTest::area(const core::Aabb& box, float solid) const {
  alignas(64) float found[kLanes];
  const float solids[kLanes] = {solid};
  of_one_box(box, [&](const auto& boxes) { return occlusion_kernels().areas(view_, boxes, solids, found), 0u; });
  return found[0];
}

void ContributionTest::areas(const core::ItemBounds& bounds, const core::VisibleSet& in,
                             std::vector<SlotArea>& areas) const {
  areas.clear();
  SolidLanes solids(solids_);
  alignas(64) float found[kLanes];
  for_each_group(bounds, in, [&](const SlotGroup& group, unsigned, bool of_range) {
    occlusion_kernels().areas(view_, group.coordinates, solids.of(group, of_range), found);
    for (int i = 0; i < group.count; ++i)
      if (!bounds.vacant(group.slots[i])) areas.push_back({group.slots[i], found[i]});
  });
}

/// Bit i: box i of sixteen has that area or more.
unsigned ContributionTest::at_least(const float* const (&coordinates)[6], const float* solids, float threshold,
                                    float (&areas)[kLanes]) const {
  occlusion_kernels().areas(view_, coordinates, solids, areas);
  unsigned found = 0;
  for (int i = 0; i < kLanes; ++i) found |= unsigned(areas[i] >= threshold) << i;
  return found;
}

void ContributionTest::filter(const core::ItemBounds& bounds, const core::VisibleSet& in, float threshold,
                              core::VisibleSet& kept, SlotBits before, SlotBits exempt) const {
  const core::Scratch<SlotCollector> scratch;
  SlotCollector& collector = *scratch;
  SolidLanes solids(solids_);
  alignas(64) float areas[kLanes];
  for_each_group(bounds, in, [&](const SlotGroup& group, unsigned used, bool of_range) {
    unsigned bits = at_least(group.coordinates, solids.of(group, of_range), kHysteresis * threshold, areas);
    for (unsigned small = bits & used; small != 0; small &= small - 1) {
      const int i = std::countr_zero(small);
      if (areas[i] < threshold && !contains(before, group.slots[i])) bits &= ~(1u << i);
    }
    bits |= bits_of(group, exempt);
    for (int i = 0; i < group.count; ++i)
      if (bounds.vacant(group.slots[i])) bits &= ~(1u << i);
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
                         [&](const auto& boxes) { return at_least(boxes, nullptr, kHysteresis * threshold, areas); });
}

void ContributionTest::splats(const core::ItemBounds& bounds, const core::VisibleSet& in, SlotBits without,
                              float least_area, SplatRule rule, std::vector<Splat>& splats) const {
  splats.clear();
  SolidLanes solids(solids_);
  BoxSplats found;
  for_each_group(bounds, in, [&](const SlotGroup& group, unsigned used, bool of_range) {
    unsigned bits = used & ~bits_of(group, without);
    if (bits == 0) return;
    occlusion_kernels().splats(view_, group.coordinates, solids.of(group, of_range), least_area,
                               rule == SplatRule::kAll, found);
    for (bits &= found.showing; bits != 0; bits &= bits - 1) {
      const int i = std::countr_zero(bits);
      splats.push_back({group.slots[i], found.x[i], found.y[i], found.distance[i], found.area[i]});
    }
  });
}

}  // namespace sightline::culling
