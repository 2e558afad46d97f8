#include "sightline/study/line_svg.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sightline/study/svg_canvas.h"

namespace sightline::study {
namespace {

using Canvas = SvgCanvas;

/// A step of 1, 2 or 5 times a power of ten that makes four to ten of a width.
double step_of(double width) {
  const double power = std::pow(10.0, std::floor(std::log10(width)));
  return width / power >= 5.0 ? power : width / power >= 2.0 ? 0.5 * power : 0.2 * power;
}

struct LinearAxis {
  double low = 0.0, high = 1.0;
  double place(double v) const { return (v - low) / (high - low); }
};

class Drawing {
 public:
  explicit Drawing(const LinePlot& plot) : plot_(plot), canvas_(plot.title, plot.x_label, plot.y_label) {
    double least_x = std::numeric_limits<double>::infinity(), most_x = -least_x, least_y = least_x, most_y = 0.0;
    for (const Line& line : plot.lines) {
      for (const auto& [x, y] : line.points) {
        least_x = std::min(least_x, x), most_x = std::max(most_x, x);
        if (y > 0.0) least_y = std::min(least_y, y), most_y = std::max(most_y, y);
      }
    }
    if (least_x < most_x) x_ = {least_x, most_x};
    if (most_y > 0.0) decades_.fit(least_y, most_y), y_.high = most_y;
  }

  std::string run() {
    ticks();
    for (std::size_t i = 0; i < plot_.lines.size(); ++i) {
      const Line& line = plot_.lines[i];
      canvas_.raw() << "<polyline fill=\"none\" stroke=\"" << Canvas::colour(i) << "\" stroke-width=\""
                    << (line.heavy ? 2.5 : 1.2) << "\" points=\"";
      for (const auto& [x, y] : line.points) canvas_.raw() << px(x) << ',' << py(y) << ' ';
      canvas_.raw() << "\"/>\n";
      canvas_.legend(i, line.label, 380);
    }
    return canvas_.finish();
  }

 private:
  void ticks() {
    const double step = step_of(x_.high - x_.low);
    for (double x = std::ceil(x_.low / step) * step; x <= x_.high; x += step) canvas_.tick_x(px(x), x);
    if (plot_.log_y) {
      for (int d = decades_.low; d <= decades_.high; ++d) canvas_.tick_y(py(std::pow(10.0, d)), std::pow(10.0, d));
      return;
    }
    for (double y = 0.0; y <= y_.high; y += step_of(y_.high)) canvas_.tick_y(py(y), y);
  }
  double px(double v) const { return Canvas::kLeft + x_.place(v) * (Canvas::kWidth - Canvas::kLeft - Canvas::kRight); }
  double py(double v) const {
    const double bottom = Canvas::kHeight - Canvas::kBottom;
    const double share = !plot_.log_y ? y_.place(v) : v > 0.0 ? decades_.place(v) : 0.0;
    return bottom - share * (bottom - Canvas::kTop);
  }

  const LinePlot& plot_;
  SvgCanvas canvas_;
  LinearAxis x_, y_;
  DecadeAxis decades_;
};

}  // namespace

std::string to_svg(const LinePlot& plot) {
  return Drawing(plot).run();
}

}  // namespace sightline::study
