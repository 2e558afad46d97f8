#include "sightline/apps/common/svg_plot.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sightline/apps/common/label_placement.h"
#include "sightline/apps/common/statistics.h"
#include "sightline/apps/common/svg_canvas.h"

namespace sightline::apps {
namespace {

/// The least 1, 2 or 5 times a power of ten that is not below `v`: axes then end and step on round numbers.
double round_up(double v) {
  if (!(v > 0.0)) return 1.0;
  const double unit = std::pow(10.0, std::floor(std::log10(v)));
  for (const double step : {1.0, 2.0, 5.0, 10.0})
    if (v <= step * unit * (1 + 1e-9)) return step * unit;
  return 10.0 * unit;
}

// --- two quantities over frames --------------------------------------------------------------------------------------

class FramePlot {
 public:
  FramePlot(const std::string& title, std::size_t frames) : frames_(std::max<std::size_t>(2, frames)) {
    svg_.text(kWidth / 2, 24, "middle", "#222", title);
    svg_.text((kLeft + kWidth - kRight) / 2, kHeight - 12, "middle", "#222", "frame");
    for (int i = 0; i <= kTicks; ++i) {
      const double x = kLeft + i * (kWidth - kLeft - kRight) / kTicks;
      svg_.text(x, kHeight - kBottom + 18, "middle", "#444",
                std::to_string(std::lround(double(i) * double(frames - 1) / kTicks)));
    }
  }

  void draw(const Marks& marks) {
    for (const auto& [first, last] : marks.bands) {
      const double left = std::max(kLeft, x_of(double(first) - 0.5));
      const double right = std::min(kWidth - kRight, x_of(double(last) + 0.5));
      svg_.rectangle(left, kTop, right - left, kHeight - kTop - kBottom, kBandColour);
    }
    for (const std::size_t frame : marks.ticks) tick(x_of(double(frame)), kTop);
    constexpr double kSwatch = 14, kY = kTop - 10;
    double x = kWidth / 2 - (marks.ticks.empty() ? 60 : 110);
    if (!marks.bands.empty()) {
      svg_.rectangle(x, kY - kTickHeight, kSwatch, kTickHeight + 2, kBandColour);
      svg_.text(x + kSwatch + 5, kY, "start", "#222", marks.band_label);
    }
    x = kWidth / 2 + 60;
    if (!marks.ticks.empty()) {
      tick(x, kY - kTickHeight + 1);
      svg_.text(x + 7, kY, "start", "#222", marks.tick_label);
    }
  }

  void draw(const Series& series, bool right) {
    const char* colour = SvgCanvas::colour(right ? 1 : 0);
    std::vector<double> known = series.values;
    std::erase_if(known, [](double value) { return value < 0.0; });
    const Summary summary = summarise(known);
    // One interrupted frame must not flatten all others. Far above the 99th percentile the line is cut, and the label
    // says so.
    constexpr double kOutlier = 3.0;
    const bool cut = summary.max > kOutlier * summary.p99;
    const double top = round_up(cut ? kOutlier * summary.p99 : summary.max);
    const double axis_x = right ? kWidth - kRight : kLeft;
    for (int i = 0; i <= kTicks; ++i) {
      const double y = y_of(double(i) / kTicks);
      if (!right) svg_.line(kLeft, y, kWidth - kRight, y);
      svg_.text(axis_x + (right ? 6 : -6), y + 4, right ? "start" : "end", colour, short_number(top * i / kTicks));
    }
    svg_.text(axis_x, kTop - 10, right ? "end" : "start", colour,
              series.label + " [" + series.unit + "]" + (cut ? ", cut; max " + short_number(summary.max) : ""));
    std::vector<std::array<double, 2>> points;
    for (std::size_t i = 0; i < series.values.size(); ++i)
      if (series.values[i] >= 0.0) points.push_back({x_of(double(i)), y_of(std::min(1.0, series.values[i] / top))});
    svg_.polyline(points, colour, 1.5);
  }

  std::string finish() { return std::move(svg_).finish(); }

 private:
  static constexpr double kWidth = 960, kHeight = 400, kLeft = 80, kRight = 90, kTop = 50, kBottom = 50;
  static constexpr int kTicks = 5;
  static constexpr const char *kBandColour = "#e3f1df", *kTickColour = "#3d8a2f";
  static constexpr double kTickHeight = 10;

  double x_of(double frame) const { return kLeft + frame / double(frames_ - 1) * (kWidth - kLeft - kRight); }
  static double y_of(double share) { return kHeight - kBottom - share * (kHeight - kTop - kBottom); }
  void tick(double x, double y) { svg_.line(x, y, x, y + kTickHeight, kTickColour, 1.5); }

  std::size_t frames_;
  SvgCanvas svg_{kWidth, kHeight};
};

// --- panels ----------------------------------------------------------------------------------------------------------

/// Logarithmic: the range of the values above 0, and a little room around it. Linear: the range of all values, from 0
/// on where asked for.
class Axis {
 public:
  enum class Kind { kLogarithmic, kLinear, kLinearFromZero };
  explicit Axis(Kind kind) : logarithmic_(kind == Kind::kLogarithmic) {
    if (kind == Kind::kLinearFromZero) least_ = most_ = 0.0;
  }

  void add(double v) {
    if (!logarithmic_ || v > 0.0) least_ = std::min(least_, v), most_ = std::max(most_, v);
  }
  bool logarithmic() const { return logarithmic_; }
  /// Place of `v` on the axis, 0 … 1.
  double share(double v) const {
    if (logarithmic_) return std::log(v / low()) / std::log(high() / low());
    return least_ < most_ ? (v - least_) / (most_ - least_) : 0.0;
  }
  /// About six values.
  std::vector<double> ticks() const {
    if (logarithmic_) return logarithmic_ticks();
    std::vector<double> values;
    if (least_ > most_) return values;
    const double step = round_up((most_ - least_) / 8);
    for (double v = std::ceil(least_ / step) * step; v <= most_; v += step) values.push_back(v);
    return values;
  }

 private:
  static constexpr double kLeastSpan = 4.0;  // ratio of the ends: a tick or more lies between
  static constexpr std::size_t kMostTicks = 7;

  bool known() const { return most_ > 0.0; }
  /// Factor from the outermost values to the ends.
  double room() const { return std::max(std::pow(most_ / least_, 0.04), std::sqrt(kLeastSpan * least_ / most_)); }
  double low() const { return known() ? least_ / room() : 1.0; }
  double high() const { return known() ? most_ * room() : 10.0; }

  /// Round multiples of powers of ten, as many as there is room for.
  std::vector<double> logarithmic_ticks() const {
    const int first = int(std::floor(std::log10(low()))), last = int(std::floor(std::log10(high())));
    const auto within = [&](int step, const std::vector<double>& factors) {
      std::vector<double> values;
      for (int decade = first; decade <= last; decade += step)
        for (const double factor : factors)
          if (const double v = factor * std::pow(10.0, decade); v >= low() && v <= high()) values.push_back(v);
      return values;
    };
    for (const std::vector<double>& factors : {std::vector{1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0}, {1.0, 2.0, 5.0}})
      if (std::vector<double> values = within(1, factors); values.size() <= kMostTicks) return values;
    return within(1 + (last - first) / int(kMostTicks), {1.0});
  }

  bool logarithmic_;
  double least_ = std::numeric_limits<double>::infinity(), most_ = -std::numeric_limits<double>::infinity();
};

/// Without an exponent where digits are as short.
std::string tick_text(double value) {
  return value >= 1000.0 && value < 1e6 ? std::to_string(std::lround(value)) : short_number(value);
}

/// Characters of UTF-8, each taken as half as wide as high and a little more.
double text_width(std::string_view text, double font_size) {
  const auto characters = std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xc0) != 0x80; });
  return 0.56 * font_size * double(characters);
}

class PanelDrawing {
 public:
  explicit PanelDrawing(const PanelPlot& plot)
      : plot_(plot),
        columns_(plot.large ? 1 : std::clamp<std::size_t>(plot.panels.size(), 1, 3)),
        panel_width_(plot.large      ? 960
                     : columns_ == 2 ? 480
                                     : 330),
        panel_height_(plot.large ? 520 : 0.76 * panel_width_),
        font_(plot.large || columns_ == 2 ? 14 : 11),
        left_room_(4.6 * font_),
        width_(std::max(660.0, double(columns_) * panel_width_)),
        x_(x_axis()),
        y_(plot.log_y ? Axis::Kind::kLogarithmic : Axis::Kind::kLinearFromZero) {
    for (const Panel& panel : plot.panels)
      for (const PanelSeries& series : panel.series) {
        if (!series.label.empty() && !find(series.label)) add_to_legend(series);
        for (const PanelSeries::Point& point : series.points) {
          x_.add(point.x), y_.add(point.y);
          zero_row_ |= plot.log_y && !(point.y > 0.0);
        }
      }
    place_legend();
    const std::size_t rows = (plot.panels.size() + columns_ - 1) / columns_;
    svg_ = SvgCanvas(width_, head_ + double(rows) * panel_height_, font_);
  }

  std::string run() {
    svg_.text(width_ / 2, 20, "middle", "#222", plot_.title);
    svg_.text(width_ / 2, 22 + 1.4 * font_, "middle", "#444", "across: " + plot_.x_label + "; up: " + plot_.y_label);
    for (const LegendEntry& entry : legend_) {
      mark(entry.x, entry.y, entry.style, entry.colour);
      svg_.text(entry.x + 8, entry.y + 0.36 * font_, "start", "#222", entry.label);
    }
    for (std::size_t i = 0; i < plot_.panels.size(); ++i) {
      const std::size_t row = i / columns_, column = i % columns_;
      left_ = double(column) * panel_width_ + left_room_;
      top_ = head_ + double(row) * panel_height_ + 2.0 * font_;
      draw(plot_.panels[i]);
    }
    return std::move(svg_).finish();
  }

 private:
  struct LegendEntry {
    std::string label;
    PanelSeries::Style style;
    std::string colour;
    double x = 0.0, y = 0.0;
  };
  /// A label that waits until all marks of its panel are known.
  struct Name {
    double x, y;
    std::string text, colour;
  };

  Axis::Kind x_axis() const { return plot_.log_x ? Axis::Kind::kLogarithmic : Axis::Kind::kLinear; }

  const LegendEntry* find(const std::string& label) const {
    const auto entry =
        std::find_if(legend_.begin(), legend_.end(), [&](const LegendEntry& e) { return e.label == label; });
    return entry == legend_.end() ? nullptr : &*entry;
  }

  void add_to_legend(const PanelSeries& series) {
    const std::string colour = series.colour.empty() ? SvgCanvas::colour(legend_.size()) : series.colour;
    legend_.push_back({series.label, series.style, colour});
  }

  /// Places the legend from left to right, in as many rows as it needs.
  void place_legend() {
    constexpr double kLeft = 20, kGap = 34;
    double x = kLeft, y = 26 + 2.6 * font_;
    for (LegendEntry& entry : legend_) {
      const double needed = text_width(entry.label, font_) + kGap;
      if (x > kLeft && x + needed > width_) x = kLeft, y += 1.5 * font_;
      entry.x = x, entry.y = y;
      x += needed;
    }
    head_ = y + font_;
  }

  /// The mark of a series in the legend. Lines differ by more than their colours.
  void mark(double x, double y, PanelSeries::Style style, const std::string& colour) {
    using Style = PanelSeries::Style;
    if (style == Style::kPoints || style == Style::kPointsAndLine)
      svg_.circle(x, y, 4, colour.c_str());
    else
      stroke({{x - 13, y}, {x + 5, y}}, style, colour);
  }

  void stroke(const std::vector<std::array<double, 2>>& points, PanelSeries::Style style, const std::string& colour) {
    using Style = PanelSeries::Style;
    svg_.polyline(points, colour.c_str(), style == Style::kHeavyLine ? 2.5 : 1.0, style == Style::kDashes);
  }

  double inner_width() const { return panel_width_ - left_room_ - 25; }
  double inner_height() const { return panel_height_ - 4.4 * font_; }
  double zero_row() const { return zero_row_ ? 14.0 : 0.0; }
  double x_of(double v) const { return left_ + x_.share(v) * inner_width(); }
  double y_of(double v) const {
    const double bottom = top_ + inner_height();
    if (y_.logarithmic() && !(v > 0.0)) return bottom;
    return bottom - zero_row() - y_.share(v) * (inner_height() - zero_row());
  }

  void draw(const Panel& panel) {
    if (plot_.own_x) {
      x_ = Axis(x_axis());
      for (const PanelSeries& series : panel.series)
        for (const PanelSeries::Point& point : series.points) x_.add(point.x);
    }
    svg_.text(left_ + inner_width() / 2, top_ - 6, "middle", "#222", panel.title);
    for (const double value : x_.ticks()) {
      const double x = x_of(value);
      svg_.line(x, top_, x, top_ + inner_height());
      svg_.text(x, top_ + inner_height() + 1.3 * font_, "middle", "#444", tick_text(value));
    }
    for (const double value : y_.ticks()) tick_y(value);
    if (zero_row_) tick_y(0.0);
    names_.clear();
    room_ = LabelPlacement({left_, top_, left_ + inner_width(), top_ + inner_height()});
    for (const PanelSeries& series : panel.series) draw(series);
    for (const Name& name : names_) draw(name);
  }

  void draw(const PanelSeries& series) {
    using Style = PanelSeries::Style;
    const LegendEntry* entry = find(series.label);
    const std::string colour = entry ? entry->colour : "#999";
    if (series.style != Style::kPoints) {
      std::vector<std::array<double, 2>> points;
      for (const PanelSeries::Point& p : series.points) points.push_back({x_of(p.x), y_of(p.y)});
      stroke(points, series.style, colour);
      room_.add_line(points);
    }
    if (series.style != Style::kPoints && series.style != Style::kPointsAndLine) return;
    const double radius = plot_.large ? 5.0 : 3.0;
    for (const PanelSeries::Point& p : series.points) {
      const double x = x_of(p.x), y = y_of(p.y);
      const std::string& hover = p.hover.empty() ? series.label + " " + p.name : p.hover;
      svg_.circle(x, y, radius, colour.c_str(), hover + ": " + short_number(p.x) + ", " + short_number(p.y));
      room_.add_mark({x - radius, y - radius, x + radius, y + radius});
      if (!p.name.empty()) names_.push_back({x, y, p.name, colour});
    }
  }

  void draw(const Name& name) {
    const int size = columns_ < 3 ? font_ - 1 : 8;
    const Rectangle at = room_.place(name.x, name.y, text_width(name.text, size), size);
    svg_.text(0.5 * (at.left + at.right), at.bottom - 0.15 * size, "middle", name.colour.c_str(), name.text, size);
    const double x = std::clamp(name.x, at.left, at.right), y = std::clamp(name.y, at.top, at.bottom);
    constexpr double kFar = 14.0;  // the label stands so far off that a line must join it to its point
    if (std::hypot(x - name.x, y - name.y) > kFar) svg_.line(name.x, name.y, x, y, name.colour.c_str(), 0.7);
  }

  void tick_y(double value) {
    const double y = y_of(value);
    svg_.line(left_, y, left_ + inner_width(), y);
    svg_.text(left_ - 5, y + 0.36 * font_, "end", "#444", tick_text(value));
  }

  const PanelPlot& plot_;
  std::size_t columns_;
  double panel_width_, panel_height_;
  int font_;
  double left_room_, width_, head_ = 0.0;
  Axis x_, y_;
  bool zero_row_ = false;  // a logarithmic y axis has a row for 0 below it
  std::vector<LegendEntry> legend_;
  double left_ = 0.0, top_ = 0.0;  // place of the panel that is drawn
  LabelPlacement room_{{}};        // in that panel
  std::vector<Name> names_;        // in that panel
  SvgCanvas svg_{0, 0};
};

}  // namespace

std::string svg_plot(const std::string& title, const Series& left, const Series& right, const Marks& marks) {
  FramePlot plot(title, std::max(left.values.size(), right.values.size()));
  plot.draw(marks);
  plot.draw(right, true);
  plot.draw(left, false);
  return plot.finish();
}

std::string svg_panels(const PanelPlot& plot) {
  return PanelDrawing(plot).run();
}

std::string svg_bars(const std::string& title, const std::array<std::string, 2>& subjects,
                     const std::vector<BarPair>& bars, double most) {
  constexpr double kLabel = 330, kWidth = 960, kTop = 60, kRow = 24, kValue = 60, kBottom = 20;
  const double height = kTop + kRow * double(bars.size()) + kBottom;
  SvgCanvas svg(kWidth, height, 11);
  svg.text(kWidth / 2, 22, "middle", "#222", title, 14);
  const auto x_of = [&](double ratio) {
    return kLabel + (std::clamp(ratio, 1.0, most) - 1.0) / (most - 1.0) * (kWidth - kLabel - kValue);
  };
  for (double tick = 1.0; tick <= most; tick += 0.5) {
    svg.line(x_of(tick), kTop - 4, x_of(tick), height - kBottom);
    svg.text(x_of(tick), height - 6, "middle", "#444", short_number(tick));
  }
  for (std::size_t k = 0; k < 2; ++k)
    svg.text(kLabel + 110 * double(k), 44, "start", SvgCanvas::colour(k), subjects[k]);
  for (std::size_t i = 0; i < bars.size(); ++i) {
    const double y = kTop + kRow * double(i);
    svg.text(kLabel - 8, y + 14, "end", "#222", bars[i].label);
    for (std::size_t k = 0; k < 2; ++k) {
      const double ratio = k == 0 ? bars[i].first : bars[i].second, top = y + 2 + 10 * double(k);
      svg.rectangle(kLabel, top, x_of(ratio) - kLabel, 9, SvgCanvas::colour(k));
      svg.text(x_of(ratio) + 4, top + 8, "start", "#444", short_number(ratio, 4), 9);
    }
  }
  return std::move(svg).finish();
}

}  // namespace sightline::apps
