// Scatter plots as SVG: both axes logarithmic, zeros on a line of their own below.
#pragma once

#include <string>
#include <vector>

namespace sightline::study {

struct ScatterPoint {
  double x = 1.0;  ///< > 0
  double y = 0.0;  ///< >= 0
  std::string label;
  int group = 0;         ///< colour
  bool named = false;    ///< label drawn; otherwise shown on hover
  bool contends = true;  ///< may be on the front
};

struct ScatterPlot {
  std::string title, x_label, y_label;
  std::vector<std::string> groups;  ///< legend
  std::vector<ScatterPoint> points;
};

std::string to_svg(const ScatterPlot& plot);

/// Indices of the points that contend and that no other such point beats in both coordinates, by rising x.
std::vector<std::size_t> pareto_front(const std::vector<ScatterPoint>& points);

}  // namespace sightline::study
