// Internal: ranges of slots that grow at their end.
#pragma once

#include <algorithm>
#include <vector>

#include "sightline/core/visible_set.h"

namespace sightline::culling {

/// Appends slots first … end - 1, which lie behind all ranges, to the last range or as one more.
inline void append_range(core::Slot first, core::Slot end, std::vector<core::SlotRange>& ranges) {
  if (!ranges.empty() && ranges.back().first + ranges.back().count == first)
    ranges.back().count += end - first;
  else
    ranges.push_back({first, end - first});
}

/// Replaces `out` by the slots of two rising lists, which then hold anything.
inline void merge_slots(std::vector<core::Slot>& a, std::vector<core::Slot>& b, std::vector<core::Slot>& out) {
  if (b.empty()) return out.swap(a);
  if (a.empty()) return out.swap(b);
  out.resize(a.size() + b.size());
  std::merge(a.begin(), a.end(), b.begin(), b.end(), out.begin());
}

}  // namespace sightline::culling
