// Hashes of grid cells. Internal.
#pragma once

#include <bit>
#include <cstdint>

#include "sightline/core/internal/hash.h"

namespace sightline::compare {

/// A hash of what `hash` stands for, followed by a coordinate of a cell.
inline std::uint64_t with_cell(std::uint64_t hash, double cell) {
  return core::mixed(hash ^ std::bit_cast<std::uint64_t>(cell + 0.0));  // + 0.0: one zero
}

}  // namespace sightline::compare
