// Prefetching what a snapshot holds of a slot. Edits touch slots all over arrays of megabytes: code that visits some
// slots calls these kPrefetchAhead slots ahead.
#pragma once

#include "sightline/core/internal/prefetch.h"
#include "sightline/core/snapshot.h"

namespace sightline::core {

void prefetch_slot(const Snapshot& snapshot, Slot slot);  ///< kind, index among those of the kind, item, material
void prefetch_box(const Snapshot& snapshot, Slot slot);   ///< box, layers
/// Placement and parameters. Reads what prefetch_slot() fetches.
void prefetch_record(const Snapshot& snapshot, Slot slot);

}  // namespace sightline::core
