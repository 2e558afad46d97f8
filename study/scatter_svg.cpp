#include "sightline/study/scatter_svg.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "sightline/study/svg_canvas.h"

namespace sightline::study {
namespace {

using Canvas = SvgCanvas;
constexpr double kZeroLine = 40;

class Drawing {
 public:
  explicit Drawing(const ScatterPlot& plot) : plot_(plot), canvas_(plot.title, plot.x_label, plot.y_label) {
    double least_x = std::numeric_limits<double>::infinity(), most_x = 0.0, least_y = least_x, most_y = 0.0;
    for (const ScatterPoint& p : plot.points) {
      least_x = std::min(least_x, p.x), most_x = std::max(most_x, p.x);
      if (p.y > 0.0) least_y = std::min(least_y, p.y), most_y = std::max(most_y, p.y);
    }
    if (most_x > 0.0) x_.fit(least_x, most_x);
    if (most_y > 0.0) y_.fit(least_y, most_y);
  }

  std::string run() {
    for (int d = x_.low; d <= x_.high; ++d) canvas_.tick_x(px(std::pow(10.0, d)), std::pow(10.0, d));
    for (int d = y_.low; d <= y_.high; ++d) canvas_.tick_y(py(std::pow(10.0, d)), std::pow(10.0, d));
    canvas_.tick_y(zero_y(), 0.0);
    canvas_.raw() << "<polyline fill=\"none\" stroke=\"#999\" stroke-dasharray=\"4 3\" points=\"";
    for (const std::size_t i : pareto_front(plot_.points))
      canvas_.raw() << px(plot_.points[i].x) << ',' << py(plot_.points[i].y) << ' ';
    canvas_.raw() << "\"/>\n";
    for (const ScatterPoint& p : plot_.points) point(p);
    for (std::size_t i = 0; i < plot_.groups.size(); ++i) canvas_.legend(i, plot_.groups[i]);
    return canvas_.finish();
  }

 private:
  static double zero_y() { return Canvas::kHeight - Canvas::kBottom; }
  double px(double v) const { return Canvas::kLeft + x_.place(v) * (Canvas::kWidth - Canvas::kLeft - Canvas::kRight); }
  double py(double v) const {
    const double bottom = zero_y() - kZeroLine;
    return v > 0.0 ? bottom - y_.place(v) * (bottom - Canvas::kTop) : zero_y();
  }
  void point(const ScatterPoint& p) {
    const char* colour = Canvas::colour(std::size_t(p.group));
    canvas_.raw() << "<circle cx=\"" << px(p.x) << "\" cy=\"" << py(p.y) << "\" r=\"4\" fill=\"" << colour
                  << "\" fill-opacity=\"0.75\"><title>" << Canvas::escaped(p.label) << ": " << p.x << ", " << p.y
                  << "</title></circle>\n";
    if (!p.named) return;
    if (px(p.x) < 0.8 * Canvas::kWidth) {
      canvas_.text(px(p.x) + 6, py(p.y) - 6, "start", colour, p.label);
    } else {  // there is no room to the right: inwards, one above the other
      canvas_.text(px(p.x) + 6, py(p.y) - 12 - 14 * crowded_++, "end", colour, p.label);
    }
  }

  const ScatterPlot& plot_;
  SvgCanvas canvas_;
  DecadeAxis x_, y_;
  int crowded_ = 0;  // labels so far at the right edge
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
