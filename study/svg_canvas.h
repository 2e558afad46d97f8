// Internal: what the plots of the study draw with.
#pragma once

#include <array>
#include <cstddef>
#include <sstream>
#include <string>

namespace sightline::study {

class SvgCanvas {
 public:
  static constexpr double kWidth = 960, kHeight = 560, kLeft = 80, kRight = 30, kTop = 50, kBottom = 60;

  SvgCanvas(const std::string& title, const std::string& x_label, const std::string& y_label);

  static const char* colour(std::size_t group);
  void line(double x1, double y1, double x2, double y2);  ///< of the grid
  void text(double x, double y, const char* anchor, const char* fill, const std::string& content);
  /// A grid line with its value.
  void tick_x(double x, double value);
  void tick_y(double y, double value);
  void legend(std::size_t entry, const std::string& label, double right = 170);
  std::ostringstream& raw() { return svg_; }
  std::string finish();

  static std::string escaped(const std::string& text);

 private:
  std::ostringstream svg_;
};

/// Whole decades around values > 0.
struct DecadeAxis {
  int low = 0, high = 1;
  void fit(double least, double most);
  double place(double v) const;  ///< 0 … 1
};

}  // namespace sightline::study
