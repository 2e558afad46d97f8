// Hashing of words. Internal: for the library's own sources.
#pragma once

#include <cstdint>

namespace sightline::core {

/// S. Vigna's splitmix64: one to one, and every output bit depends on all input bits.
inline std::uint64_t mixed(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
  x = (x ^ x >> 27) * 0x94d049bb133111ebu;
  return x ^ x >> 31;
}

}  // namespace sightline::core
