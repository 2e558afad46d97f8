// Finds room for the labels of points in a plot: no label covers another one, a mark, or the plot's edge where there is
// a place that does not.
#pragma once

#include <array>
#include <vector>

namespace sightline::apps {

/// Pixels, y pointing down.
struct Rectangle {
  double left = 0.0, top = 0.0, right = 0.0, bottom = 0.0;
};

class LabelPlacement {
 public:
  /// Labels stay inside of `area` where they can.
  explicit LabelPlacement(const Rectangle& area) : area_(area) {}

  /// A mark that labels must not cover.
  void add_mark(const Rectangle& mark) { taken_.push_back(mark); }
  /// A line that labels cover only where there is no other room.
  void add_line(const std::vector<std::array<double, 2>>& points);
  /// The rectangle for a label of a size near the point, with the least overlap of those tried; it is then taken.
  Rectangle place(double x, double y, double width, double height);

 private:
  double cost(const Rectangle& label) const;

  Rectangle area_;
  std::vector<Rectangle> taken_;
  std::vector<std::array<double, 2>> line_points_;  // a few pixels apart
};

}  // namespace sightline::apps
