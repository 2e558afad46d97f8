// Which ends of items are hidden at joints (gpuprims/internal/joints.h), as a scene cache stores it with a snapshot.
#pragma once

#include <cstdint>

#include "sightline/core/internal/large_array.h"

namespace sightline::core {

struct StoredJoints {
  LargeArray<std::uint64_t> bits;    ///< two per item
  LargeArray<std::uint64_t> covers;  ///< rising: covering item << 32 | covered item << 1 | its end is the top
  LargeArray<std::uint32_t> first;   ///< per 32 items: index of the first entry in `covers`
  LargeArray<std::uint8_t> opaque;   ///< by material, as it was when joints were looked for
};

}  // namespace sightline::core
