// Draws the plots of svg_plot.h.
#pragma once

#include <array>
#include <cstddef>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

namespace sightline::apps {

/// An SVG image with a white background. Lengths are pixels, y points down, colours are "#rrggbb". Text may hold any
/// bytes: markup characters are escaped.
class SvgCanvas {
 public:
  SvgCanvas(double width, double height, int font_size = 12);

  /// Colours that tell series apart; they repeat after nine.
  static const char* colour(std::size_t series);

  /// `anchor`: "start", "middle" or "end". `size`: font size; 0: that of the canvas.
  void text(double x, double y, const char* anchor, const char* fill, std::string_view content, int size = 0);
  void line(double x1, double y1, double x2, double y2, const char* stroke = "#ddd", double width = 1.0);
  void rectangle(double x, double y, double width, double height, const char* fill);
  /// `hover`: shown under the pointer.
  void circle(double x, double y, double radius, const char* fill, std::string_view hover = {});
  void polyline(const std::vector<std::array<double, 2>>& points, const char* stroke, double width = 1.0,
                bool dashed = false);

  /// The file's text. Nothing may be drawn after it.
  std::string finish() &&;

 private:
  std::ostringstream svg_;
};

std::string short_number(double value, int significant_digits = 3);

}  // namespace sightline::apps
