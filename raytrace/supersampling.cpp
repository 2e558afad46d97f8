#include "sightline/raytrace/internal/supersampling.h"

#include <algorithm>
#include <cmath>

namespace sightline::raytrace {

std::vector<std::uint8_t> mark_edges(std::span<const core::vec3> colours, int width, int height, double threshold) {
  std::vector<std::uint8_t> marks(colours.size());
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const auto at = [&](int dx, int dy) -> const core::vec3& {
        const int column = std::clamp(x + dx, 0, width - 1), row = std::clamp(y + dy, 0, height - 1);
        return colours[std::size_t(row) * std::size_t(width) + std::size_t(column)];
      };
      const core::vec3 gx = at(1, -1) - at(-1, -1) + 2.0f * (at(1, 0) - at(-1, 0)) + at(1, 1) - at(-1, 1);
      const core::vec3 gy = at(-1, 1) - at(-1, -1) + 2.0f * (at(0, 1) - at(0, -1)) + at(1, 1) - at(1, -1);
      const core::vec3 square = gx * gx + gy * gy;
      const double gradient = std::sqrt(double(std::max({square.x, square.y, square.z})));
      marks[std::size_t(y) * std::size_t(width) + std::size_t(x)] = std::min(gradient, 1.0) > threshold;
    }
  return marks;
}

}  // namespace sightline::raytrace
