// Internal to the importers: numbers of any type and either byte order in file images.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace sightline::importers {

enum class NumberType : std::uint8_t {
  kInt8,
  kUint8,
  kInt16,
  kUint16,
  kInt32,
  kUint32,
  kInt64,
  kUint64,
  kFloat,
  kDouble
};

constexpr std::size_t size_of(NumberType type) {
  constexpr std::size_t kSizes[] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
  return kSizes[std::size_t(type)];
}

/// Calls use() with a zero of the type and returns its result.
template <class Use>
decltype(auto) with_type(NumberType type, Use&& use) {
  switch (type) {
    case NumberType::kInt8:
      return use(std::int8_t{});
    case NumberType::kUint8:
      return use(std::uint8_t{});
    case NumberType::kInt16:
      return use(std::int16_t{});
    case NumberType::kUint16:
      return use(std::uint16_t{});
    case NumberType::kInt32:
      return use(std::int32_t{});
    case NumberType::kUint32:
      return use(std::uint32_t{});
    case NumberType::kInt64:
      return use(std::int64_t{});
    case NumberType::kUint64:
      return use(std::uint64_t{});
    case NumberType::kFloat:
      return use(float{});
    default:
      return use(double{});
  }
}

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
