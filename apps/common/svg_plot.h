// Line plots as SVG: two quantities over the frames of a path, each with its own axis.
#pragma once

#include <string>
#include <vector>

namespace sightline::apps {

struct Series {
  std::string label, unit;
  std::vector<double> values;  ///< one per frame, >= 0
};

/// A plot with `left` against the left axis and `right` against the right one.
std::string svg_plot(const std::string& title, const Series& left, const Series& right);

}  // namespace sightline::apps
