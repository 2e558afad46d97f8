// Radix sort of slots and ids, least significant digit first. Faster than a comparison sort from a few hundred keys on.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <vector>

namespace sightline::core {

/// The number to sort an id by, or a key that is a number.
template <class Key>
constexpr auto radix_number(Key key) {
  if constexpr (std::is_enum_v<Key>)
    return std::underlying_type_t<Key>(key);
  else
    return key;
}

/// Sorts in rising order by the 32 bits from kLowest up, which are the key's highest bits. The order among equal bits
/// is unspecified.
template <int kLowest = 0, class Key>
void radix_sort(std::vector<Key>& keys) {
  constexpr std::size_t kFew = 512;
  if (keys.size() < kFew)
    return std::sort(keys.begin(), keys.end(),
                     [](Key a, Key b) { return radix_number(a) >> kLowest < radix_number(b) >> kLowest; });
  constexpr int kBits = 11, kDigits = 3;
  constexpr std::size_t kValues = std::size_t(1) << kBits;
  const auto digit_of = [](Key key, int digit) {
    return std::size_t(std::uint32_t(radix_number(key) >> kLowest) >> (digit * kBits)) & (kValues - 1);
  };
  std::array<std::array<std::uint32_t, kValues>, kDigits> places{};
  for (const Key key : keys)
    for (int digit = 0; digit < kDigits; ++digit) ++places[std::size_t(digit)][digit_of(key, digit)];
  std::vector<Key> sorted(keys.size());
  for (int digit = 0; digit < kDigits; ++digit) {
    auto& place = places[std::size_t(digit)];
    std::uint32_t next = 0;
    for (std::uint32_t& p : place) {
      const std::uint32_t count = p;
      p = next;
      next += count;
    }
    for (const Key key : keys) sorted[place[digit_of(key, digit)]++] = key;
    keys.swap(sorted);
  }
}

}  // namespace sightline::core
