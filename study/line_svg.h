// Line plots as SVG: linear x, y linear or logarithmic.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace sightline::study {

struct Line {
  std::string label;
  std::vector<std::pair<double, double>> points;  ///< finite; by rising x
  bool heavy = false;
};

struct LinePlot {
  std::string title, x_label, y_label;
  bool log_y = true;  ///< values <= 0 are then drawn at the bottom
  std::vector<Line> lines;
};

std::string to_svg(const LinePlot& plot);

}  // namespace sightline::study
