// Visible sets as plain lists, for consumers that need every item by itself. A set of ranges is smaller and faster to
// read: use it where it suffices.
#pragma once

#include <cstdint>
#include <span>

#include "sightline/core/visible_set.h"

namespace sightline::culling {

/// Writes every slot of `set` to the front of `out`, which has room for set.count() of them: ranges first, then single
/// slots, both in rising order. At the speed of memory.
void list_slots(const core::VisibleSet& set, std::span<core::Slot> out);

/// Lists ids[slot] for every slot. Half as fast, since the map is read as well.
void list_ids(const core::VisibleSet& set, std::span<const std::uint32_t> ids, std::span<std::uint32_t> out);

}  // namespace sightline::culling
