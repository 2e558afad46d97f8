#include "sightline/culling/frustum/linear_culler.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <vector>

#include "sightline/culling/frustum/internal/append_range.h"
#include "sightline/culling/frustum/internal/kernels.h"

namespace sightline::culling {

void cull_slots(const core::ItemBounds& bounds, const CullPlanes& planes, PlaneMask mask, std::uint32_t layers,
                core::SlotRange slots, core::VisibleSet& set) {
  std::size_t first = slots.first;
  const std::size_t end = first + slots.count;
  assert(end <= bounds.size());
  if (first == end || (!bounds.uses_layers() && (layers & core::kLayerModel) == 0)) return;
  set.counters.boxes_tested += end - first;
  const ItemTest test = make_item_test(bounds, planes, layers);
  std::array<core::Slot, kItemsAtOnce + kLanes> items;
  std::array<core::Slot, kItemsAtOnce / kLanes + 1> edges;
  for (; first < end; first += kItemsAtOnce) {
    FoundSlots found{items.data(), edges.data()};
    frustum_kernels().cull_items(test, mask, first, std::min(end, first + kItemsAtOnce), found);
    set.single_slots.insert(set.single_slots.end(), items.data(), found.items);
    for (const core::Slot* edge = edges.data(); edge < found.edges; edge += 2)
      append_range(edge[0], edge[1], set.ranges);
  }
}

void LinearCuller::cull(const core::View& view, core::VisibleSet& set) const {
  set.clear();
  const CullPlanes planes(view, *bounds_);
  if (planes.nothing_visible()) return;
  cull_slots(*bounds_, planes, planes.all(), view.layers, {0, std::uint32_t(bounds_->size())}, set);
}

}  // namespace sightline::culling
