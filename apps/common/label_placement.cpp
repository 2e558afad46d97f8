#include "sightline/apps/common/label_placement.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sightline::apps {
namespace {

double area_of(const Rectangle& r) {
  return std::max(0.0, r.right - r.left) * std::max(0.0, r.bottom - r.top);
}

Rectangle intersection(const Rectangle& a, const Rectangle& b) {
  return {std::max(a.left, b.left), std::max(a.top, b.top), std::min(a.right, b.right), std::min(a.bottom, b.bottom)};
}

bool contains(const Rectangle& r, const std::array<double, 2>& p) {
  return p[0] >= r.left && p[0] <= r.right && p[1] >= r.top && p[1] <= r.bottom;
}

}  // namespace

void LabelPlacement::add_line(const std::vector<std::array<double, 2>>& points) {
  constexpr double kStep = 4.0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const auto &from = points[i - 1], &to = points[i];
    const int steps = 1 + int(std::hypot(to[0] - from[0], to[1] - from[1]) / kStep);
    for (int k = 0; k <= steps; ++k) {
      const double t = double(k) / steps;
      line_points_.push_back({std::lerp(from[0], to[0], t), std::lerp(from[1], to[1], t)});
    }
  }
}

double LabelPlacement::cost(const Rectangle& label) const {
  constexpr double kCovered = 10.0, kLinePoint = 4.0;  // of a square pixel, of a point of a line
  double covered = area_of(label) - area_of(intersection(label, area_));
  for (const Rectangle& taken : taken_) covered += area_of(intersection(label, taken));
  const auto on_line = std::count_if(line_points_.begin(), line_points_.end(),
                                     [&](const auto& point) { return contains(label, point); });
  return kCovered * covered + kLinePoint * double(on_line);
}

Rectangle LabelPlacement::place(double x, double y, double width, double height) {
  constexpr double kGap = 9.0, kFarthest = 8.0;
  constexpr double kDistanceCost = 0.5;  // a place next to the point is better than a distant one that is as free
  constexpr std::array<std::array<double, 2>, 8> kDirections{
      {{1, -0.5}, {1, 0.5}, {-1, -0.5}, {-1, 0.5}, {0, -1}, {0, 1}, {1, 0}, {-1, 0}}};
  Rectangle best;
  double least = std::numeric_limits<double>::infinity();
  for (double distance = 1.0; distance <= kFarthest; distance += 0.5)
    for (const auto& [across, down] : kDirections) {
      const double middle_x = x + across * (0.5 * width + kGap * distance);
      const double middle_y = y + down * (0.5 * height + kGap * distance);
      const Rectangle label{middle_x - 0.5 * width, middle_y - 0.5 * height, middle_x + 0.5 * width,
                            middle_y + 0.5 * height};
      const double price = cost(label) + kDistanceCost * (distance - 1.0);
      if (price < least) least = price, best = label;
    }
  taken_.push_back(best);
  return best;
}

}  // namespace sightline::apps
