#include "sightline/study/scatter_svg.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <sstream>

namespace sightline::study {
namespace {

constexpr double kWidth = 960, kHeight = 560, kLeft = 80, kRight = 30, kTop = 50, kBottom = 60, kZeroLine = 40;
constexpr std::array<const char*, 8> kColours{"#1f6fb4", "#d9731a", "#2c9c3f", "#c23b3b",
                                              "#7b52ab", "#7f5a46", "#d65fa8", "#222222"};

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : std::string(1, c);
  return out;
}

/// Whole decades around the values.
struct Axis {
  int low = 0, high = 1;
  void fit(double least, double most) {
    low = int(std::floor(std::log10(least)));
    high = std::max(low + 1, int(std::ceil(std::log10(most))));
  }
  double place(double v) const { return (std::log10(v) - low) / (high - low); }
};

class Drawing {
 public:
  explicit Drawing(const ScatterPlot& plot) : plot_(plot) {
    double least_x = std::numeric_limits<double>::infinity(), most_x = 0.0, least_y = least_x, most_y = 0.0;
    for (const ScatterPoint& p : plot.points) {
      least_x = std::min(least_x, p.x), most_x = std::max(most_x, p.x);
      if (p.y > 0.0) least_y = std::min(least_y, p.y), most_y = std::max(most_y, p.y);
    }
    if (most_x > 0.0) x_.fit(least_x, most_x);
    if (most_y > 0.0) y_.fit(least_y, most_y);
  }

  std::string run() {
    svg_ << "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" << kWidth << "\" height=\"" << kHeight
         << "\" font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n";
    text(kWidth / 2, 24, "middle", "#222", plot_.title);
    text((kLeft + kWidth - kRight) / 2, kHeight - 12, "middle", "#222", plot_.x_label);
    text(kLeft, kTop - 10, "start", "#222", plot_.y_label);
    for (int d = x_.low; d <= x_.high; ++d) tick(px(std::pow(10.0, d)), true, d);
    for (int d = y_.low; d <= y_.high; ++d) tick(py(std::pow(10.0, d)), false, d);
    line(kLeft, zero_y(), kWidth - kRight, zero_y());
    text(kLeft - 6, zero_y() + 4, "end", "#444", "0");
    svg_ << "<polyline fill=\"none\" stroke=\"#999\" stroke-dasharray=\"4 3\" points=\"";
    for (const std::size_t i : pareto_front(plot_.points))
      svg_ << px(plot_.points[i].x) << ',' << py(plot_.points[i].y) << ' ';
    svg_ << "\"/>\n";
    for (const ScatterPoint& p : plot_.points) point(p);
    for (std::size_t i = 0; i < plot_.groups.size(); ++i) {
      const double y = kTop + 8 + 16.0 * double(i);
      svg_ << "<circle cx=\"" << kWidth - kRight - 170 << "\" cy=\"" << y << "\" r=\"4\" fill=\"" << colour(int(i))
           << "\"/>\n";
      text(kWidth - kRight - 160, y + 4, "start", "#222", plot_.groups[i]);
    }
    svg_ << "</svg>\n";
    return svg_.str();
  }

 private:
  static const char* colour(int group) { return kColours[std::size_t(group) % kColours.size()]; }
  static double zero_y() { return kHeight - kBottom; }
  double px(double v) const { return kLeft + x_.place(v) * (kWidth - kLeft - kRight); }
  double py(double v) const {
    const double bottom = zero_y() - kZeroLine;
    return v > 0.0 ? bottom - y_.place(v) * (bottom - kTop) : zero_y();
  }
  void line(double x1, double y1, double x2, double y2) {
    svg_ << "<line x1=\"" << x1 << "\" y1=\"" << y1 << "\" x2=\"" << x2 << "\" y2=\"" << y2 << "\" stroke=\"#ddd\"/>\n";
  }
  void text(double x, double y, const char* anchor, const char* fill, const std::string& content) {
    svg_ << "<text x=\"" << x << "\" y=\"" << y << "\" text-anchor=\"" << anchor << "\" fill=\"" << fill << "\">"
         << escaped(content) << "</text>\n";
  }
  void tick(double at, bool along_x, int decade) {
    std::ostringstream label;
    label << std::pow(10.0, decade);
    if (along_x) {
      line(at, kTop, at, zero_y());
      text(at, zero_y() + 18, "middle", "#444", label.str());
    } else {
      line(kLeft, at, kWidth - kRight, at);
      text(kLeft - 6, at + 4, "end", "#444", label.str());
    }
  }
  void point(const ScatterPoint& p) {
    svg_ << "<circle cx=\"" << px(p.x) << "\" cy=\"" << py(p.y) << "\" r=\"4\" fill=\"" << colour(p.group)
         << "\" fill-opacity=\"0.75\"><title>" << escaped(p.label) << ": " << p.x << ", " << p.y
         << "</title></circle>\n";
    if (p.named) text(px(p.x) + 6, py(p.y) - 6, "start", colour(p.group), p.label);
  }

  const ScatterPlot& plot_;
  Axis x_, y_;
  std::ostringstream svg_;
};

}  // namespace

std::string to_svg(const ScatterPlot& plot) {
  return Drawing(plot).run();
}

std::vector<std::size_t> pareto_front(const std::vector<ScatterPoint>& points) {
  std::vector<std::size_t> by_x(points.size()), front;
  std::iota(by_x.begin(), by_x.end(), std::size_t(0));
  std::sort(by_x.begin(), by_x.end(), [&](std::size_t a, std::size_t b) {
    return points[a].x < points[b].x || (points[a].x == points[b].x && points[a].y < points[b].y);
  });
  double best = std::numeric_limits<double>::infinity();
  for (const std::size_t i : by_x) {
    if (!points[i].contends || points[i].y >= best) continue;
    best = points[i].y;
    front.push_back(i);
  }
  return front;
}

}  // namespace sightline::study
