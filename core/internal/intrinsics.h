// One name for each compiler intrinsic that C++ lacks, or has only in a form that kernels must not use.
//
// Static, not inline: files compiled for wider instruction sets include this header. The linker might choose their copy
// of an inline function (some of <bit> are inline) for code that runs on every processor. All other files use <bit>.
#pragma once

#include <cstdint>

#if defined(_MSC_VER) && !defined(__clang__)
#include <intrin.h>
#endif

namespace sightline::core {

/// std::countr_zero for bits != 0.
static inline unsigned lowest_bit(std::uint32_t bits) {
#if defined(__GNUC__)
  return unsigned(__builtin_ctz(bits));
#else
  unsigned long place;
  _BitScanForward(&place, bits);
  return place;
#endif
}
static inline unsigned lowest_bit(std::uint64_t bits) {
#if defined(__GNUC__)
  return unsigned(__builtin_ctzll(bits));
#else
  const auto low = std::uint32_t(bits);
  return low != 0 ? lowest_bit(low) : 32u + lowest_bit(std::uint32_t(bits >> 32));
#endif
}

/// The cache level that a line is wanted in, or one nearer to the core.
enum class CacheLevel { kL1, kL2 };

/// Prefetches the cache line of an address. Any address is allowed.
template <CacheLevel kLevel>
static inline void prefetch_line([[maybe_unused]] const void* address) {
#if defined(__GNUC__)
  __builtin_prefetch(address, 0, kLevel == CacheLevel::kL1 ? 3 : 2);
#elif defined(_M_X64)
  _mm_prefetch(static_cast<const char*>(address), kLevel == CacheLevel::kL1 ? _MM_HINT_T0 : _MM_HINT_T1);
#endif
}

/// For a spin loop that waits for another core: leaves the execution units to the core's other hardware thread.
static inline void pause() {
#if defined(__GNUC__) && defined(__x86_64__)
  __builtin_ia32_pause();
#elif defined(__GNUC__) && defined(__aarch64__)
  asm volatile("yield");
#elif defined(_M_X64)
  _mm_pause();
#endif
}

}  // namespace sightline::core
