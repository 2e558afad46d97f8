// Plots as SVG: two quantities over the frames of a path, each with its own axis, and what held in which frames; and
// small log-log plots side by side, for errors against what they cost.
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

/// In one colour wherever the label is the same.
struct PanelSeries {
  struct Point {
    double x = 1.0, y = 0.0;  ///< x > 0; y >= 0, where 0 lies on a line of its own below
    std::string name;         ///< beside the point; may be empty
  };
  std::string label;
  std::vector<Point> points;  ///< joined by a line in this order
};

struct Panel {
  std::string title;
  std::vector<PanelSeries> series;
};

/// Log-log panels, three in a row, with the same axes and one legend. With `own_x` each panel has its own x axis.
std::string svg_panels(const std::string& title, const std::string& x_label, const std::string& y_label,
                       const std::vector<Panel>& panels, bool own_x = false);

}  // namespace sightline::apps
