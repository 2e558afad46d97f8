// Hashing of words. Internal: for the library's own sources.
#pragma once

#include <cstdint>
#include <string_view>

namespace sightline::core {

/// S. Vigna's splitmix64: one to one, and every output bit depends on all input bits.
inline std::uint64_t mixed(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
  x = (x ^ x >> 27) * 0x94d049bb133111ebu;
  return x ^ x >> 31;
}

/// FNV-1a, continued by the next piece of a text: tells accidents and names apart, not attacks.
inline constexpr std::uint64_t kFnvBasis = 0xcbf29ce484222325u;
constexpr std::uint64_t fnv1a(std::string_view bytes, std::uint64_t so_far = kFnvBasis) {
  for (const char byte : bytes) so_far = (so_far ^ static_cast<unsigned char>(byte)) * 0x100000001b3u;
  return so_far;
}

}  // namespace sightline::core
