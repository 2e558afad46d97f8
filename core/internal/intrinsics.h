// What C++ has no word for, or only one that kernels must not use: one name for what every compiler has under its own.
//
// Static, not inline: files compiled for wider instruction sets include this, and of an inline function (those of <bit>
// are some) a copy made there could be linked into code for every processor. All other files use <bit>.
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

/// The cache that a line is wanted in, at least.
enum class CacheLevel { kL1, kL2 };

/// Asks for the line of an address, which may be any.
template <CacheLevel kLevel>
static inline void prefetch_line([[maybe_unused]] const void* address) {
#if defined(__GNUC__)
  __builtin_prefetch(address, 0, kLevel == CacheLevel::kL1 ? 3 : 2);
#elif defined(_M_X64)
  _mm_prefetch(static_cast<const char*>(address), kLevel == CacheLevel::kL1 ? _MM_HINT_T0 : _MM_HINT_T1);
#endif
}

/// In a loop that waits for another core: leaves the execution units to whom they serve.
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
