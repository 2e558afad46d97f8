#include "sightline/core/visible_set.h"

#include <algorithm>
#include <numeric>

namespace sightline::core {

std::vector<Slot> VisibleSet::sorted_slots() const {
  std::vector<Slot> slots = items;
  for (const SlotRange& range : ranges) {
    const std::size_t old = slots.size();
    slots.resize(old + range.count);
    std::iota(slots.begin() + std::ptrdiff_t(old), slots.end(), range.first);
  }
  std::sort(slots.begin(), slots.end());
  return slots;
}

}  // namespace sightline::core
