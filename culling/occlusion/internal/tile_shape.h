// Internal: which blocks of pixels the lanes of a BlockTile look at. Not for files that define kernels.
#pragma once

#include <algorithm>

#include "sightline/culling/occlusion/internal/kernels.h"

namespace sightline::culling {

/// How sixteen blocks of pixels lie: in rows of 1, 2, 4, 8 or 16, so that few lanes look beside a narrow rectangle.
struct TileShape {
  /// For rectangles of that width, in blocks.
  explicit TileShape(int width) : columns_log2(width > 8 ? 4 : width > 4 ? 3 : width > 2 ? 2 : width > 1 ? 1 : 0) {}
  int columns() const { return 1 << columns_log2; }
  int rows() const { return kLanes >> columns_log2; }
  /// Bits of the lanes in the lower left width x height blocks of the tile, both positive.
  unsigned lanes(int width, int height) const {
    const unsigned row = (1u << std::min(width, columns())) - 1u;
    unsigned bits = 0;
    for (int y = 0; y < std::min(height, rows()); ++y) bits |= row << (y << columns_log2);
    return bits;
  }
  int x(int lane) const { return lane & (columns() - 1); }
  int y(int lane) const { return lane >> columns_log2; }

  int columns_log2;
};

}  // namespace sightline::culling
