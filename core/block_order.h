// The order of a snapshot's items in space, also for boxes of an application's own (culling/frustum/cpu_culler.h): each
// aligned block of a power of two of places lies together, so that a hierarchy over the order needs neither indices nor
// counts. In parallel with OpenMP.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/aabb.h"
#include "sightline/core/api.h"

namespace sightline::core {

struct BlockOrderOptions {
  std::uint32_t smallest_block = 8;  ///< boxes of a block of this size or smaller are in no particular order; > 0
  int threads = 0;                   ///< 0: all that OpenMP offers, of few boxes one. The order does not depend on it
};

/// result[place] = index into `boxes`. The whole range is split across the longest axis of the boxes' centroids, into
/// the largest power of two that leaves something, and the rest; both parts are split in the same way. The left part
/// holds the boxes with the smaller centroids, ties by index. Deterministic; time O(n log n) on any input. Empty boxes
/// are allowed and gather with the others at the origin. No box may hold a NaN (asserted).
SIGHTLINE_API std::vector<std::uint32_t> block_order(std::span<const Aabb> boxes, const BlockOrderOptions& config = {});

}  // namespace sightline::core
