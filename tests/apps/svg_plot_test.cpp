// Plots: marks lie where their frames are, and what is not known leaves the line as it is.
#include "sightline/apps/common/svg_plot.h"

#include <algorithm>
#include <sstream>

#include <gtest/gtest.h>

namespace sightline::apps::svg_plot_test {
namespace {

/// Occurrences of a piece of text.
std::ptrdiff_t count(const std::string& text, const std::string& piece) {
  std::ptrdiff_t found = 0;
  for (std::size_t i = text.find(piece); i != std::string::npos; i = text.find(piece, i + 1)) ++found;
  return found;
}

const Series kLeft{"time", "ms", {1, 2, 3, 4, 5}};

TEST(SvgPlot, WithoutMarksThereIsNoLegend) {
  EXPECT_EQ(svg_plot("a", kLeft, kLeft), svg_plot("a", kLeft, kLeft, {"bands", {}, "ticks", {}}));
  EXPECT_EQ(count(svg_plot("a", kLeft, kLeft), "bands"), 0);
}

/// Frames 0 to 4 are 197.5 pixels apart from 80 on; a band reaches half a frame to either side, but not out of the
/// plot.
TEST(SvgPlot, BandsCoverTheirFrames) {
  const std::string svg = svg_plot("a", kLeft, kLeft, {"bands", {{0, 1}, {3, 3}}, "ticks", {}});
  EXPECT_EQ(count(svg, "<rect x=\"80\" y=\"50\" width=\"296.25\" height=\"300\""), 1) << svg;
  EXPECT_EQ(count(svg, "<rect x=\"573.75\" y=\"50\" width=\"197.5\" height=\"300\""), 1) << svg;
  EXPECT_EQ(count(svg, "<rect x="), 3) << "two bands and the legend's";
  EXPECT_EQ(count(svg, ">bands<"), 1);
  EXPECT_EQ(count(svg, ">ticks<"), 0);
}

TEST(SvgPlot, TicksStandAtTheirFrames) {
  const std::string svg = svg_plot("a", kLeft, kLeft, {"bands", {}, "ticks", {2, 4}});
  EXPECT_EQ(count(svg, "<line x1=\"475\" y1=\"50\" x2=\"475\""), 1) << svg;
  EXPECT_EQ(count(svg, "<line x1=\"870\" y1=\"50\" x2=\"870\""), 1) << svg;
  EXPECT_EQ(count(svg, ">ticks<"), 1);
  EXPECT_EQ(count(svg, ">bands<"), 0);
}

TEST(SvgPlot, TheLinePassesOverWhatIsNotKnown) {
  const std::string svg = svg_plot("a", {"time", "ms", {1, -1, 3, -1, 5}}, kLeft);
  const std::size_t line = svg.rfind("points=\"");
  EXPECT_EQ(svg.substr(line, svg.find(" \"", line) - line), "points=\"80,290 475,170 870,50");
}

/// Places of the points of the first line.
std::vector<std::array<double, 2>> line_of(const std::string& svg) {
  std::vector<std::array<double, 2>> points;
  const std::size_t begin = svg.find("points=\"") + 8;
  std::istringstream text(svg.substr(begin, svg.find('"', begin) - begin));
  char comma;
  for (std::array<double, 2> p; text >> p[0] >> comma >> p[1];) points.push_back(p);
  return points;
}

TEST(SvgPanels, PointsStandAtTheirLogarithms) {
  const std::string svg =
      svg_panels({"a", "x", "y", {{"one", {{"s", {{1, 0.1, ""}, {10, 1, "mid"}, {100, 10, ""}}}}}}});
  const auto points = line_of(svg);
  ASSERT_EQ(points.size(), 3u) << svg;
  for (const int axis : {0, 1}) EXPECT_NEAR(points[1][axis], 0.5 * (points[0][axis] + points[2][axis]), 0.01);
  EXPECT_LT(points[0][0], points[2][0]);
  EXPECT_GT(points[0][1], points[2][1]) << "y points down";
  EXPECT_EQ(count(svg, ">mid<"), 1);
  EXPECT_EQ(count(svg, "<circle"), 4) << "three points and the legend's";
  EXPECT_EQ(count(svg, ">0<"), 0) << "no row for 0, which is not there";
}

/// Values within a decade take most of the plot, and the axis has ticks between them.
TEST(SvgPanels, LogarithmicAxesFitTheValues) {
  const std::string svg = svg_panels({.panels = {{"", {{"s", {{30, 2, ""}, {70, 6, ""}}}}}}, .large = true});
  const auto points = line_of(svg);
  ASSERT_EQ(points.size(), 2u);
  EXPECT_GT(points[1][0] - points[0][0], 450.0) << svg;
  for (const char* tick : {">40<", ">50<", ">60<"}) EXPECT_EQ(count(svg, tick), 1) << tick;
}

TEST(SvgPanels, ZeroLiesBelowAndLabelsShareColours) {
  const Panel first{"one", {{"s", {{1, 0, ""}, {100, 10, ""}}}, {"t", {{10, 0.1, ""}}}}},
      second{"two", {{"t", {{10, 1, ""}}}}};
  const std::string svg = svg_panels({"a", "x", "y", {first, second}});
  EXPECT_EQ(count(svg, ">0<"), 2) << "a row for 0 in both panels";
  EXPECT_EQ(count(svg, "fill=\"#d9731a\""), 3) << "t in the legend and in both panels";
}

/// So that one thing has one colour in all plots of a page, in whatever order it comes.
TEST(SvgPanels, ColoursMayBeChosen) {
  using Style = PanelSeries::Style;
  const PanelSeries s{"s", {{1, 1, ""}}, Style::kPoints, "#123456"}, t{"t", {{2, 2, ""}}, Style::kLine, "#abcdef"};
  for (const std::vector<PanelSeries>& series : {std::vector{s, t}, std::vector{t, s}}) {
    const std::string svg = svg_panels({"a", "x", "y", {{"one", series}}});
    EXPECT_EQ(count(svg, "fill=\"#123456\""), 2) << svg;
    EXPECT_EQ(count(svg, "stroke=\"#abcdef\""), 2) << svg;
  }
}

TEST(SvgPanels, TheUpwardAxisMayBeLinearFromZero) {
  const PanelSeries line{"", {{1, 0, ""}, {2, 50, ""}, {3, 100, ""}}, PanelSeries::Style::kLine};
  const auto points = line_of(svg_panels({.panels = {{"", {line}}}, .log_x = false, .log_y = false}));
  ASSERT_EQ(points.size(), 3u);
  EXPECT_NEAR(points[1][1], 0.5 * (points[0][1] + points[2][1]), 0.01);
}

TEST(SvgPanels, AxesMayBeLinear) {
  const PanelSeries line{"", {{2, 1, ""}, {4, 10, ""}, {10, 1, ""}}, PanelSeries::Style::kLine};
  const std::string svg = svg_panels({.panels = {{"", {line}}}, .log_x = false, .large = true});
  const auto points = line_of(svg);
  ASSERT_EQ(points.size(), 3u) << svg;
  EXPECT_NEAR(points[1][0] - points[0][0], 0.25 * (points[2][0] - points[0][0]), 0.01);
  EXPECT_EQ(count(svg, "<circle"), 0) << "neither points nor a legend";
  for (const int tick : {3, 4, 6, 7, 8, 9}) EXPECT_EQ(count(svg, ">" + std::to_string(tick) + "<"), 1) << tick;
}

TEST(SvgPanels, LongLegendsTakeMoreRows) {
  std::vector<PanelSeries> series;
  for (const char letter : {'a', 'b', 'c'}) series.push_back({std::string(60, letter), {{1, 1, ""}}});
  const std::string svg = svg_panels({"a", "x", "y", {{"one", std::move(series)}}});
  EXPECT_EQ(count(svg, "<circle cx=\"20\" cy="), 3) << svg;
}

TEST(SvgPanels, LabelsMayHoldMarkup) {
  const std::string svg = svg_panels({"t<itle", "a & b", "y", {{"one", {{"l<1", {{1, 1, "p>2", "h<3"}}}}}}});
  for (const char* text : {"t&lt;itle", "a &amp; b", ">l&lt;1<", ">p&gt;2<", "h&lt;3"}) EXPECT_EQ(count(svg, text), 1);
}

/// A flat line, a single point, and no values above 0 still have axes.
TEST(SvgPanels, AnySeriesHasAxes) {
  for (const bool log_x : {false, true})
    for (const std::vector<PanelSeries::Point>& points :
         {std::vector<PanelSeries::Point>{}, {{3, 3, ""}}, {{1, 0, ""}, {2, 0, ""}}}) {
      const std::string svg = svg_panels({.panels = {{"", {{"s", points}}}}, .log_x = log_x});
      EXPECT_EQ(count(svg, "nan") + count(svg, "inf"), 0) << svg;
    }
}

TEST(SvgBars, BarsStartAtOneAndAreCut) {
  const std::string svg = svg_bars("a", {"first", "second"}, {{"one", 1.0, 2.5}, {"two", 4.0, 99.0}});
  EXPECT_EQ(count(svg, "width=\"0\""), 1) << svg;
  EXPECT_EQ(count(svg, "width=\"285\""), 1) << svg;
  EXPECT_EQ(count(svg, "width=\"570\""), 2) << svg;
  EXPECT_EQ(count(svg, ">99<"), 1) << "what is cut carries its value";
}

TEST(SvgPanels, NothingIsNoError) {
  EXPECT_EQ(count(svg_panels({"a", "x", "y"}), "</svg>"), 1);
}

}  // namespace
}  // namespace sightline::apps::svg_plot_test
