// Memory of the operating system. Internal.
#pragma once

#include <cstddef>
#include <cstdint>

#include "sightline/core/api.h"

namespace sightline::core::platform {

SIGHTLINE_API std::size_t page_size();
/// Bytes that the machine has; 0 where it cannot be told.
SIGHTLINE_API std::uint64_t physical_memory();
/// Bytes that the process has in memory; 0 where it cannot be told.
SIGHTLINE_API std::size_t process_memory();
/// The most that the process has had in memory; 0 where it cannot be told.
SIGHTLINE_API std::size_t peak_memory();
/// Gives what was freed back to the system, as far as the C library keeps it.
SIGHTLINE_API void give_back_free_memory();

/// Zeros in whole pages, which take no memory before they are touched. Null where the system has no more.
SIGHTLINE_API void* reserve_pages(std::size_t bytes);
SIGHTLINE_API void release_pages(void* memory, std::size_t bytes);

// AddressSanitizer watches the bounds of what `new` returns, not of pages.
#if defined(__linux__) && !defined(__SANITIZE_ADDRESS__)
inline constexpr bool kHasHugePages = true;
#else
inline constexpr bool kHasHugePages = false;
#endif
inline constexpr std::size_t kHugePage = std::size_t(2) << 20;

/// Zeros in huge pages, where there are any: `bytes` and the address are multiples of kHugePage. Released by
/// release_pages(). The functions below are for such memory.
SIGHTLINE_API void* reserve_huge_pages(std::size_t bytes);
/// Moves pages without copying them. `to`: reserved, and at least as large. False where the system cannot; then nobody
/// knows whether `to` is still reserved.
SIGHTLINE_API bool move_huge_pages(void* from, std::size_t bytes, void* to, std::size_t to_bytes);
/// For what may stay untouched: small pages take less memory then.
SIGHTLINE_API void prefer_small_pages(void* memory, std::size_t bytes);

}  // namespace sightline::core::platform
