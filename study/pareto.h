// The Pareto front of points.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <numeric>
#include <span>
#include <vector>

namespace sightline::study {

/// Indices of the points that no other point beats in both coordinates (less is better), by rising x.
inline std::vector<std::size_t> pareto_front(std::span<const std::array<double, 2>> points) {
  std::vector<std::size_t> by_x(points.size()), front;
  std::iota(by_x.begin(), by_x.end(), std::size_t(0));
  std::sort(by_x.begin(), by_x.end(), [&](std::size_t a, std::size_t b) { return points[a] < points[b]; });
  double best = std::numeric_limits<double>::infinity();
  for (const std::size_t i : by_x) {
    if (points[i][1] >= best) continue;
    best = points[i][1];
    front.push_back(i);
  }
  return front;
}

}  // namespace sightline::study
