#include "sightline/culling/frustum/internal/slot_list.h"

#include <algorithm>
#include <cassert>

#include "sightline/culling/frustum/internal/kernels.h"

namespace sightline::culling {

void list_slots(const core::VisibleSet& set, std::span<core::Slot> out) {
  assert(out.size() >= set.count());
  const auto count_up = frustum_kernels().count_up;
  core::Slot* to = out.data();
  for (const core::SlotRange& range : set.ranges) {
    count_up(to, range.first, range.count);
    to += range.count;
  }
  std::copy(set.single_slots.begin(), set.single_slots.end(), to);
}

void list_ids(const core::VisibleSet& set, std::span<const std::uint32_t> ids, std::span<std::uint32_t> out) {
  assert(out.size() >= set.count());
  std::uint32_t* to = out.data();
  for (const core::SlotRange& range : set.ranges) to = std::copy_n(ids.data() + range.first, range.count, to);
  for (const core::Slot slot : set.single_slots) *to++ = ids[slot];
}

}  // namespace sightline::culling
