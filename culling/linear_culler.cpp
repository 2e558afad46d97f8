#include "sightline/culling/linear_culler.h"

#include <bit>
#include <cassert>
#include <cstddef>
#include <vector>

namespace sightline::culling {
namespace {

unsigned on_layers(const core::ItemBounds& bounds, std::uint32_t layers, std::size_t first, unsigned lanes) {
  unsigned kept = 0;
  for (unsigned rest = lanes; rest != 0; rest &= rest - 1) {
    const int i = std::countr_zero(rest);
    if ((bounds.layers(first + std::size_t(i)) & layers) != 0) kept |= 1u << i;
  }
  return kept;
}

/// Collects slots on the stack and appends them many at a time.
class SlotWriter {
 public:
  explicit SlotWriter(std::vector<core::Slot>& items) : items_(items) {}
  ~SlotWriter() { flush(); }
  SlotWriter(const SlotWriter&) = delete;
  SlotWriter& operator=(const SlotWriter&) = delete;

  void write(core::Slot group, unsigned lanes) {
    if (count_ + kLanes > kCapacity) flush();
    core::Slot* out = buffer_ + count_;
    if (lanes == 0xffu) {
      for (core::Slot i = 0; i < core::Slot(kLanes); ++i) out[i] = group + i;
      count_ += kLanes;
      return;
    }
    for (; lanes != 0; lanes &= lanes - 1) *out++ = group + core::Slot(std::countr_zero(lanes));
    count_ = out - buffer_;
  }

 private:
  static constexpr std::ptrdiff_t kCapacity = 256;
  void flush() {
    items_.insert(items_.end(), buffer_, buffer_ + count_);
    count_ = 0;
  }
  std::vector<core::Slot>& items_;
  std::ptrdiff_t count_ = 0;
  core::Slot buffer_[kCapacity];
};

}  // namespace

void cull_slots(const core::ItemBounds& bounds, const CullPlanes& planes, PlaneMask mask, std::uint32_t layers,
                std::size_t first, std::size_t end, core::VisibleSet& set) {
  assert(first <= end && end <= bounds.size());
  const bool look_at_layers = bounds.uses_layers();
  if (!look_at_layers && (layers & core::kLayerModel) == 0) return;
  set.counters.boxes_tested += end - first;
  SlotWriter writer(set.items);
  for (std::size_t group = first; group < end; group += kLanes) {
    unsigned lanes = planes.visible(bounds, group, mask);
    if (end - group < std::size_t(kLanes)) lanes &= (1u << (end - group)) - 1u;
    if (look_at_layers) lanes = on_layers(bounds, layers, group, lanes);
    writer.write(core::Slot(group), lanes);
  }
}

void LinearCuller::cull(const core::View& view, core::VisibleSet& set) const {
  set.clear();
  const CullPlanes planes(view, *bounds_);
  if (planes.nothing_visible()) return;
  cull_slots(*bounds_, planes, planes.all(), view.layers, 0, bounds_->size(), set);
}

}  // namespace sightline::culling
