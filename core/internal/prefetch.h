// Prefetching. An edit touches items all over arrays of hundreds of megabytes. Without prefetching, its time is that of
// one cache miss after another.
#pragma once

#include <cstddef>

#include "sightline/core/internal/intrinsics.h"

namespace sightline::core {

/// Elements between prefetch and use. A prefetch that needs the result of another one is made half as far ahead.
inline constexpr std::size_t kPrefetchAhead = 16;

inline void prefetch(const void* address, std::size_t bytes) {
  const char* first = static_cast<const char*>(address);
  for (std::size_t line = 0; line < bytes; line += 64) prefetch_line<CacheLevel::kL2>(first + line);
  if (bytes > 1) prefetch_line<CacheLevel::kL2>(first + bytes - 1);
  asm volatile("");  // g++ 12 takes a function that only prefetches for one without effect, and drops its calls
}
template <class T>
void prefetch(const T& object) {
  prefetch(&object, sizeof(T));
}

}  // namespace sightline::core
