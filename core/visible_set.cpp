#include "sightline/core/visible_set.h"

#include <algorithm>
#include <numeric>

namespace sightline::core {

std::vector<Slot> VisibleSet::sorted_slots() const {
  std::vector<Slot> all = single_slots;
  for (const SlotRange& range : ranges) {
    const std::size_t old = all.size();
    all.resize(old + range.count);
    std::iota(all.begin() + std::ptrdiff_t(old), all.end(), range.first);
  }
  std::sort(all.begin(), all.end());
  return all;
}

}  // namespace sightline::core
