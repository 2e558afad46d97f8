// Internal: ranges of slots that grow at their end.
#pragma once

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

}  // namespace sightline::culling
