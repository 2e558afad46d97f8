// Checks of arrays that were read, on all threads. Internal to the scene cache.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>

#include "sightline/core/error.h"

namespace sightline::importers::storage {

inline tl::unexpected<core::Error> inconsistent(const char* what, std::size_t index) {
  return core::fail(std::string("its ") + what + " " + std::to_string(index) + " is inconsistent");
}

/// The first index below `count` that does not hold, or `count`. Uses all threads.
template <class Holds>
std::size_t first_wrong(std::size_t count, const Holds& holds) {
  std::size_t wrong = count;
#ifdef _OPENMP
#pragma omp parallel for schedule(static) reduction(min : wrong) if (count > 65536)
#endif
  for (std::size_t i = 0; i < count; ++i)
    if (!holds(i)) wrong = std::min(wrong, i);
  return wrong;
}

}  // namespace sightline::importers::storage
