// Internal to the importers: numbers of either byte order in file images.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace sightline::importers {

/// The number whose sizeof(T) bytes begin at `from`, aligned or not.
template <class T, std::endian kOrder>
T load(const std::byte* from) {
  using Bits = std::conditional_t<sizeof(T) == 1, std::uint8_t,
                                  std::conditional_t<sizeof(T) == 2, std::uint16_t,
                                                     std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>>>;
  static_assert(sizeof(T) == sizeof(Bits));
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    const std::size_t shift = 8 * (kOrder == std::endian::little ? i : sizeof(T) - 1 - i);
    bits |= std::uint64_t(from[i]) << shift;
  }
  return std::bit_cast<T>(Bits(bits));
}

}  // namespace sightline::importers
