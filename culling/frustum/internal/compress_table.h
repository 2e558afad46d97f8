// Internal: for lanes that instruction sets cannot compress themselves. Lies in the anonymous namespace of each file.
#pragma once

#include <cstdint>

namespace sightline::culling {
namespace {

/// Row m: the places of the bits of m, in rising order.
struct CompressTable {
  alignas(8) std::uint8_t rows[256][8];
  constexpr CompressTable() : rows() {
    for (unsigned m = 0; m < 256; ++m)
      for (unsigned i = 0, n = 0; i < 8; ++i)
        if ((m >> i & 1u) != 0) rows[m][n++] = std::uint8_t(i);
  }
};
constexpr CompressTable kCompress;

}  // namespace

}  // namespace sightline::culling
