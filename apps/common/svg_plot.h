// Line plots as SVG: two quantities over the frames of a path, each with its own axis, and what held in which frames.
#pragma once

#include <array>
#include <string>
#include <vector>

namespace sightline::apps {

struct Series {
  std::string label, unit;
  std::vector<double> values;  ///< one per frame; below 0: not known, the line passes over it
};

/// Behind the lines; the legend names only what there is.
struct Marks {
  std::string band_label;
  std::vector<std::array<std::size_t, 2>> bands;  ///< shaded: first and last frame
  std::string tick_label;
  std::vector<std::size_t> ticks;  ///< a tick at the upper edge: frames
};

/// A plot with `left` against the left axis and `right` against the right one.
std::string svg_plot(const std::string& title, const Series& left, const Series& right, const Marks& marks = {});

}  // namespace sightline::apps
