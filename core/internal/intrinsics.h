// One name for each compiler intrinsic that C++ lacks, or has only in a form that kernels must not use. The library is
// compiled by GCC or Clang, also for Visual C++, since kernels use the vector types of those; its public headers are for
// any compiler.
//
// Static, not inline: files compiled for wider instruction sets include this header. The linker might choose their copy
// of an inline function (some of <bit> are inline) for code that runs on every processor. All other files use <bit>.
#pragma once

#include <cstdint>

namespace sightline::core {

/// std::countr_zero for bits != 0.
static inline unsigned lowest_bit(std::uint32_t bits) {
  return unsigned(__builtin_ctz(bits));
}
static inline unsigned lowest_bit(std::uint64_t bits) {
  return unsigned(__builtin_ctzll(bits));
}

/// The cache level that a line is wanted in, or one nearer to the core.
enum class CacheLevel { kL1, kL2 };

/// Prefetches the cache line of an address. Any address is allowed.
template <CacheLevel kLevel>
static inline void prefetch_line(const void* address) {
  __builtin_prefetch(address, 0, kLevel == CacheLevel::kL1 ? 3 : 2);
}

/// For a spin loop that waits for another core: leaves the execution units to the core's other hardware thread.
static inline void pause() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

}  // namespace sightline::core
