// Equally spaced planes across each axis, as the uniform grid and the Sparse Box Grid have them.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "sightline/core/aabb.h"

namespace sightline::study::rays {

using Cell = std::array<std::int32_t, 3>;

struct GridLines {
  Cell cells{1, 1, 1};  ///< number along each axis
  core::vec3 low{0.0f}, cell{1.0f}, per_cell{1.0f};

  GridLines() = default;
  GridLines(const core::Aabb& bounds, const Cell& number)
      : cells(number),
        low(bounds.min),
        cell((bounds.max - bounds.min) / core::vec3(float(number[0]), float(number[1]), float(number[2]))),
        per_cell(1.0f / cell) {}

  /// The plane below cell i.
  float line(int axis, std::int32_t i) const { return low[axis] + float(i) * cell[axis]; }
  /// Cell of a position, the first or last one for a position outside.
  std::int32_t cell_of(int axis, float position) const {
    return std::int32_t(std::clamp((position - low[axis]) * per_cell[axis], 0.0f, float(cells[axis] - 1)));
  }
  std::size_t count() const { return std::size_t(cells[0]) * std::size_t(cells[1]) * std::size_t(cells[2]); }
  std::size_t index(const Cell& c) const {
    return (std::size_t(c[2]) * std::size_t(cells[1]) + std::size_t(c[1])) * std::size_t(cells[0]) + std::size_t(c[0]);
  }
};

/// Numbers of cells as near to cubes with this edge as can be; the edge grows until they are at most `most` in all. No
/// axis has more than 65535.
inline Cell near_cubes(const core::Aabb& bounds, double edge, double most) {
  for (;; edge *= 1.125) {
    Cell cells;
    double count = 1.0;
    for (int a = 0; a < 3; ++a) {
      const double size = double(bounds.max[a]) - double(bounds.min[a]);
      cells[std::size_t(a)] = std::int32_t(std::clamp(std::round(size / edge), 1.0, 65535.0));
      count *= cells[std::size_t(a)];
    }
    if (count <= std::max(1.0, most)) return cells;
  }
}

}  // namespace sightline::study::rays
