#include "sightline/culling/linear_culler.h"

#include <array>
#include <cassert>

#include "sightline/culling/kernels.h"

namespace sightline::culling {
namespace {

constexpr std::size_t kBuffer = 4096;

/// Collects slots on the stack and appends them many at a time.
struct Writer {
  explicit Writer(core::VisibleSet& target) : set(target) {
    lists = {buffer.data(), buffer.data() + kBuffer - kLanes, this, flush};
  }
  static void flush(SlotLists& lists) {
    auto* writer = static_cast<Writer*>(lists.owner);
    writer->set.items.insert(writer->set.items.end(), writer->buffer.data(), lists.items);
    lists.items = writer->buffer.data();
  }

  core::VisibleSet& set;
  SlotLists lists;
  std::array<core::Slot, kBuffer> buffer;
};

}  // namespace

void cull_slots(const core::ItemBounds& bounds, const CullPlanes& planes, PlaneMask mask, std::uint32_t layers,
                std::size_t first, std::size_t end, core::VisibleSet& set) {
  assert(first <= end && end <= bounds.size());
  if (first == end || (!bounds.uses_layers() && (layers & core::kLayerModel) == 0)) return;
  set.counters.boxes_tested += end - first;
  Writer writer(set);
  kernels().cull_items(make_item_test(bounds, planes, layers), mask, first, end, writer.lists);
  Writer::flush(writer.lists);
}

void LinearCuller::cull(const core::View& view, core::VisibleSet& set) const {
  set.clear();
  const CullPlanes planes(view, *bounds_);
  if (planes.nothing_visible()) return;
  cull_slots(*bounds_, planes, planes.all(), view.layers, 0, bounds_->size(), set);
}

}  // namespace sightline::culling
