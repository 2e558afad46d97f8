#include "sightline/apps/common/svg_plot.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "sightline/apps/common/statistics.h"

namespace sightline::apps {
namespace {

constexpr double kWidth = 960, kHeight = 400, kLeft = 80, kRight = 90, kTop = 50, kBottom = 50;
constexpr int kTicks = 5;
constexpr const char* kColours[2] = {"#1f6fb4", "#d9731a"};
constexpr const char *kBandColour = "#e3f1df", *kTickColour = "#3d8a2f";
constexpr double kTickHeight = 10;

/// The next of 1, 2, 5 times a power of ten, so that axes end on round numbers.
double round_up(double v) {
  if (!(v > 0.0)) return 1.0;
  const double unit = std::pow(10.0, std::floor(std::log10(v)));
  for (const double step : {1.0, 2.0, 5.0, 10.0})
    if (v <= step * unit * (1 + 1e-9)) return step * unit;
  return 10.0 * unit;
}

std::string short_number(double v) {
  std::ostringstream text;
  text.precision(3);
  text << v;
  return text.str();
}

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '&')
      out += "&amp;";
    else
      out += c;
  }
  return out;
}

class Plot {
 public:
  Plot(const std::string& title, std::size_t frames) : frames_(std::max<std::size_t>(2, frames)) {
    svg_ << "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" << kWidth << "\" height=\"" << kHeight
         << "\" font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n";
    text(kWidth / 2, 24, "middle", "#222", title);
    text((kLeft + kWidth - kRight) / 2, kHeight - 12, "middle", "#222", "frame");
    for (int i = 0; i <= kTicks; ++i) {
      const double x = kLeft + i * (kWidth - kLeft - kRight) / kTicks;
      std::ostringstream label;
      label << std::lround(double(i) * double(frames - 1) / kTicks);
      text(x, kHeight - kBottom + 18, "middle", "#444", label.str());
    }
  }

  void draw(const Marks& marks) {
    for (const auto& [first, last] : marks.bands) {
      const double left = std::max(kLeft, x_of(double(first) - 0.5));
      const double right = std::min(kWidth - kRight, x_of(double(last) + 0.5));
      rectangle(left, kTop, right - left, kHeight - kTop - kBottom);
    }
    for (const std::size_t frame : marks.ticks) tick(x_of(double(frame)), kTop);
    constexpr double kSwatch = 14, kY = kTop - 10;
    double x = kWidth / 2 - (marks.ticks.empty() ? 60 : 110);
    if (!marks.bands.empty()) {
      rectangle(x, kY - kTickHeight, kSwatch, kTickHeight + 2);
      text(x + kSwatch + 5, kY, "start", "#222", marks.band_label);
    }
    x = kWidth / 2 + 60;
    if (!marks.ticks.empty()) {
      tick(x, kY - kTickHeight + 1);
      text(x + 7, kY, "start", "#222", marks.tick_label);
    }
  }

  void draw(const Series& series, bool right) {
    const char* colour = kColours[right ? 1 : 0];
    std::vector<double> known = series.values;
    std::erase_if(known, [](double value) { return value < 0.0; });
    const apps::Summary summary = summarise(known);
    // One interrupted frame must not flatten all others: far above the 99th percentile the line is cut, and the label
    // says so.
    constexpr double kOutlier = 3.0;
    const bool cut = summary.max > kOutlier * summary.p99;
    const double top = round_up(cut ? kOutlier * summary.p99 : summary.max);
    const double axis_x = right ? kWidth - kRight : kLeft;
    for (int i = 0; i <= kTicks; ++i) {
      const double y = y_of(double(i) / kTicks);
      if (!right)
        svg_ << "<line x1=\"" << kLeft << "\" y1=\"" << y << "\" x2=\"" << kWidth - kRight << "\" y2=\"" << y
             << "\" stroke=\"#ddd\"/>\n";
      std::ostringstream label;
      label << top * i / kTicks;
      text(axis_x + (right ? 6 : -6), y + 4, right ? "start" : "end", colour, label.str());
    }
    text(axis_x, kTop - 10, right ? "end" : "start", colour,
         series.label + " [" + series.unit + "]" + (cut ? ", cut; max " + short_number(summary.max) : ""));
    svg_ << "<polyline fill=\"none\" stroke=\"" << colour << "\" stroke-width=\"1.5\" points=\"";
    for (std::size_t i = 0; i < series.values.size(); ++i)
      if (series.values[i] >= 0.0) svg_ << x_of(double(i)) << ',' << y_of(std::min(1.0, series.values[i] / top)) << ' ';
    svg_ << "\"/>\n";
  }

  std::string finish() {
    svg_ << "</svg>\n";
    return svg_.str();
  }

 private:
  double x_of(double frame) const { return kLeft + frame / double(frames_ - 1) * (kWidth - kLeft - kRight); }
  static double y_of(double share) { return kHeight - kBottom - share * (kHeight - kTop - kBottom); }
  void text(double x, double y, const char* anchor, const char* colour, const std::string& content) {
    svg_ << "<text x=\"" << x << "\" y=\"" << y << "\" text-anchor=\"" << anchor << "\" fill=\"" << colour << "\">"
         << escaped(content) << "</text>\n";
  }
  void rectangle(double x, double y, double width, double height) {
    svg_ << "<rect x=\"" << x << "\" y=\"" << y << "\" width=\"" << width << "\" height=\"" << height << "\" fill=\""
         << kBandColour << "\"/>\n";
  }
  void tick(double x, double y) {
    svg_ << "<line x1=\"" << x << "\" y1=\"" << y << "\" x2=\"" << x << "\" y2=\"" << y + kTickHeight << "\" stroke=\""
         << kTickColour << "\" stroke-width=\"1.5\"/>\n";
  }
  std::size_t frames_;
  std::ostringstream svg_;
};

/// Whole decades, at least one.
struct Decades {
  double least = std::numeric_limits<double>::infinity(), most = 0.0;
  void add(double v) {
    if (v > 0.0) least = std::min(least, v), most = std::max(most, v);
  }
  int low() const { return most > 0.0 ? int(std::floor(std::log10(least))) : 0; }
  int high() const { return most > 0.0 ? std::max(low() + 1, int(std::ceil(std::log10(most)))) : 1; }
  double share(double v) const { return (std::log10(v) - low()) / (high() - low()); }
};

class Panels {
 public:
  Panels(const std::vector<Panel>& panels, bool own_x) : panels_(panels), own_x_(own_x) {
    for (const Panel& panel : panels)
      for (const PanelSeries& series : panel.series) {
        if (std::find(labels_.begin(), labels_.end(), series.label) == labels_.end()) labels_.push_back(series.label);
        for (const PanelSeries::Point& point : series.points) x_.add(point.x), y_.add(point.y);
      }
  }

  std::string run(const std::string& title, const std::string& x_label, const std::string& y_label) {
    const std::size_t columns = std::min(kColumns, panels_.size());
    const std::size_t rows = columns == 0 ? 0 : (panels_.size() + columns - 1) / columns;
    const double width = std::max(2.0, double(columns)) * kPanelWidth, height = kHead + double(rows) * kPanelHeight;
    svg_ << "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" << width << "\" height=\"" << height
         << "\" font-family=\"sans-serif\" font-size=\"11\">\n"
         << "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n";
    text(width / 2, 20, "middle", "#222", title);
    text(width / 2, 38, "middle", "#444", "across: " + x_label + "; up: " + y_label);
    for (std::size_t i = 0; i < labels_.size(); ++i) {
      const double x = 20 + (width - 40) * double(i) / double(labels_.size());
      svg_ << "<circle cx=\"" << x << "\" cy=\"54\" r=\"4\" fill=\"" << colour(i) << "\"/>\n";
      text(x + 8, 58, "start", "#222", labels_[i]);
    }
    for (std::size_t i = 0; i < panels_.size(); ++i) {
      const std::size_t row = i / columns;
      left_ = double(i % columns) * kPanelWidth + 50;
      top_ = kHead + double(row) * kPanelHeight + 22;
      draw(panels_[i]);
    }
    svg_ << "</svg>\n";
    return svg_.str();
  }

 private:
  static constexpr std::size_t kColumns = 3;
  static constexpr double kPanelWidth = 330, kPanelHeight = 250, kHead = 66, kZeroRow = 14;
  static constexpr double kInnerWidth = kPanelWidth - 75, kInnerHeight = kPanelHeight - 48;

  static const char* colour(std::size_t i) {
    static constexpr const char* kAll[] = {"#1f6fb4", "#d9731a", "#2c9c3f", "#c23b3b",
                                           "#7b52ab", "#7f5a46", "#d65fa8", "#222222"};
    return kAll[i % std::size(kAll)];
  }
  double x_of(double v) const { return left_ + x_.share(v) * kInnerWidth; }
  double y_of(double v) const {
    const double bottom = top_ + kInnerHeight;
    return v > 0.0 ? bottom - kZeroRow - y_.share(v) * (kInnerHeight - kZeroRow) : bottom;
  }

  void draw(const Panel& panel) {
    if (own_x_) {
      x_ = {};
      for (const PanelSeries& series : panel.series)
        for (const PanelSeries::Point& point : series.points) x_.add(point.x);
    }
    text(left_ + kInnerWidth / 2, top_ - 6, "middle", "#222", panel.title);
    for (int d = x_.low(), step = 1 + (x_.high() - x_.low()) / 6; d <= x_.high(); d += step) {
      const double value = std::pow(10.0, d), x = x_of(value);
      line(x, top_, x, top_ + kInnerHeight);
      text(x, top_ + kInnerHeight + 14, "middle", "#444", short_number(value));
    }
    const int step = std::max(1, (y_.high() - y_.low()) / 6);
    for (int d = y_.low(); d <= y_.high(); d += step) tick_y(std::pow(10.0, d));
    tick_y(0.0);
    for (const PanelSeries& series : panel.series) draw(series);
  }
  void draw(const PanelSeries& series) {
    const char* fill = colour(std::size_t(std::find(labels_.begin(), labels_.end(), series.label) - labels_.begin()));
    svg_ << "<polyline fill=\"none\" stroke=\"" << fill << "\" points=\"";
    for (const PanelSeries::Point& p : series.points) svg_ << x_of(p.x) << ',' << y_of(p.y) << ' ';
    svg_ << "\"/>\n";
    for (const PanelSeries::Point& p : series.points) {
      svg_ << "<circle cx=\"" << x_of(p.x) << "\" cy=\"" << y_of(p.y) << "\" r=\"3\" fill=\"" << fill << "\"><title>"
           << escaped(series.label + " " + p.name) << ": " << short_number(p.x) << ", " << short_number(p.y)
           << "</title></circle>\n";
      if (!p.name.empty())
        svg_ << "<text x=\"" << x_of(p.x) + 5 << "\" y=\"" << y_of(p.y) - 4 << "\" font-size=\"8\" fill=\"" << fill
             << "\">" << escaped(p.name) << "</text>\n";
    }
  }
  void tick_y(double value) {
    const double y = y_of(value);
    line(left_, y, left_ + kInnerWidth, y);
    text(left_ - 5, y + 4, "end", "#444", short_number(value));
  }
  void line(double x1, double y1, double x2, double y2) {
    svg_ << "<line x1=\"" << x1 << "\" y1=\"" << y1 << "\" x2=\"" << x2 << "\" y2=\"" << y2 << "\" stroke=\"#ddd\"/>\n";
  }
  void text(double x, double y, const char* anchor, const char* fill, const std::string& content) {
    svg_ << "<text x=\"" << x << "\" y=\"" << y << "\" text-anchor=\"" << anchor << "\" fill=\"" << fill << "\">"
         << escaped(content) << "</text>\n";
  }

  const std::vector<Panel>& panels_;
  bool own_x_;
  std::vector<std::string> labels_;
  Decades x_, y_;
  double left_ = 0.0, top_ = 0.0;  // of the panel that is drawn
  std::ostringstream svg_;
};

}  // namespace

std::string svg_panels(const std::string& title, const std::string& x_label, const std::string& y_label,
                       const std::vector<Panel>& panels, bool own_x) {
  return Panels(panels, own_x).run(title, x_label, y_label);
}

std::string svg_plot(const std::string& title, const Series& left, const Series& right, const Marks& marks) {
  Plot plot(title, std::max(left.values.size(), right.values.size()));
  plot.draw(marks);
  plot.draw(right, true);
  plot.draw(left, false);
  return plot.finish();
}

}  // namespace sightline::apps
