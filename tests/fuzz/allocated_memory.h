// Counts heap bytes, as the sanitizer's allocator sees them.
#pragma once

#include <cstddef>

namespace sightline::fuzz {

/// The largest amount of heap memory held since construction, beyond what was held then. One at a time.
class PeakMemory {
 public:
  PeakMemory();
  std::size_t bytes() const;
};

}  // namespace sightline::fuzz
