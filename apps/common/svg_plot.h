// Plots as SVG: two quantities over the frames of a path, panels of series with logarithmic axes, and pairs of bars.
#pragma once

#include <array>
#include <string>
#include <vector>

namespace sightline::apps {

// --- two quantities over frames --------------------------------------------------------------------------------------

struct Series {
  std::string label, unit;
  std::vector<double> values;  ///< one per frame; below 0: not known, and the line skips it
};

/// Marks behind the lines. The legend names only marks that occur.
struct Marks {
  std::string band_label;
  std::vector<std::array<std::size_t, 2>> bands;  ///< shaded: first and last frame
  std::string tick_label;
  std::vector<std::size_t> ticks;  ///< ticks at the upper edge: frames
};

/// A plot with `left` against the left axis and `right` against the right one.
std::string svg_plot(const std::string& title, const Series& left, const Series& right, const Marks& marks = {});

// --- panels ----------------------------------------------------------------------------------------------------------

/// Series with the same label have the same colour, that of the first.
struct PanelSeries {
  struct Point {
    double x = 1.0, y = 0.0;  ///< x > 0 on a logarithmic axis; y >= 0: on one, 0 lies on a separate line below
    std::string name;         ///< beside the point, where it covers nothing
    std::string hover = {};   ///< shown under the pointer; empty: the label and the name
  };
  enum class Style { kPointsAndLine, kPoints, kLine, kHeavyLine, kDashes };

  std::string label;          ///< empty: grey, and not in the legend
  std::vector<Point> points;  ///< a line joins them in this order
  Style style = Style::kPointsAndLine;
  std::string colour = {};  ///< "#rrggbb"; empty: one that tells the plot's labels apart
};

struct Panel {
  std::string title;
  std::vector<PanelSeries> series;
};

/// Panels with the same axes, which fit the values of all, and one legend.
struct PanelPlot {
  std::string title = {}, x_label = {}, y_label = {};
  std::vector<Panel> panels = {};
  bool log_x = true;
  bool log_y = true;   ///< false: linear, from 0 on
  bool own_x = false;  ///< each panel has its own x axis
  bool large = false;  ///< panels as wide as the image instead of three in a row
};
std::string svg_panels(const PanelPlot& plot);

// --- bars ------------------------------------------------------------------------------------------------------------

/// Ratios >= 1 of two subjects.
struct BarPair {
  std::string label;
  double first = 1.0, second = 1.0;
};

/// Horizontal bars from 1 to `most`. Longer bars are cut there. Each bar shows its value.
std::string svg_bars(const std::string& title, const std::array<std::string, 2>& subjects,
                     const std::vector<BarPair>& bars, double most = 4.0);

}  // namespace sightline::apps
