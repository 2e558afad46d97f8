// What a culler answers and a renderer draws.
#pragma once

#include <cstdint>
#include <vector>

#include "sightline/core/api.h"
#include "sightline/core/conventions.h"

namespace sightline::core {

/// Slots first … first + count - 1.
struct SlotRange {
  Slot first = 0;
  std::uint32_t count = 0;
  friend bool operator==(const SlotRange&, const SlotRange&) = default;
};

/// What one cull call cost, in work rather than time.
struct CullCounters {
  std::uint64_t nodes_tested = 0;  ///< hierarchy boxes tested against at least one plane
  std::uint64_t boxes_tested = 0;  ///< item boxes tested
};

/// The visible slots of one view, not ids of items: Snapshot::item() turns a slot into the item's id. Ranges and single
/// slots are each in rising order, disjoint, and share no slot. A slot outside both is not visible. Ranges may hold
/// vacant slots, which have nothing to draw (see snapshot.h); single slots are never vacant. Reuse one set from frame
/// to frame: clear() keeps the memory.
struct SIGHTLINE_API VisibleSet {
  std::uint64_t generation = 0;   ///< of the snapshot that the slots belong to
  std::vector<SlotRange> ranges;  ///< neighbours that are all visible
  std::vector<Slot> single_slots;
  CullCounters counters;

  void clear() {
    ranges.clear();
    single_slots.clear();
    counters = {};
  }
  /// Slots, vacant ones included; Snapshot::count leaves those out.
  std::uint64_t count() const {
    std::uint64_t n = single_slots.size();
    for (const SlotRange& r : ranges) n += r.count;
    return n;
  }
  /// Calls visit(slot) for each slot, vacant ones included: first those of ranges, then single ones.
  template <class Visit>
  void for_each_slot(const Visit& visit) const {
    for (const SlotRange& r : ranges)
      for (Slot slot = r.first; slot < r.first + r.count; ++slot) visit(slot);
    for (const Slot slot : single_slots) visit(slot);
  }
  /// All visible slots in rising order, vacant ones included.
  std::vector<Slot> sorted_slots() const;
};

}  // namespace sightline::core
