#include "sightline/study/svg_canvas.h"

#include <algorithm>
#include <cmath>

namespace sightline::study {
namespace {

constexpr std::array<const char*, 9> kColours{"#1f6fb4", "#d9731a", "#2c9c3f", "#c23b3b", "#7b52ab",
                                              "#7f5a46", "#d65fa8", "#222222", "#17becf"};

std::string number(double value) {
  std::ostringstream out;
  out << value;
  return out.str();
}

}  // namespace

SvgCanvas::SvgCanvas(const std::string& title, const std::string& x_label, const std::string& y_label) {
  svg_ << "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" << kWidth << "\" height=\"" << kHeight
       << "\" font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n";
  text(kWidth / 2, 24, "middle", "#222", title);
  text((kLeft + kWidth - kRight) / 2, kHeight - 12, "middle", "#222", x_label);
  text(kLeft, kTop - 10, "start", "#222", y_label);
}

const char* SvgCanvas::colour(std::size_t group) {
  return kColours[group % kColours.size()];
}

void SvgCanvas::line(double x1, double y1, double x2, double y2) {
  svg_ << "<line x1=\"" << x1 << "\" y1=\"" << y1 << "\" x2=\"" << x2 << "\" y2=\"" << y2 << "\" stroke=\"#ddd\"/>\n";
}

void SvgCanvas::text(double x, double y, const char* anchor, const char* fill, const std::string& content) {
  svg_ << "<text x=\"" << x << "\" y=\"" << y << "\" text-anchor=\"" << anchor << "\" fill=\"" << fill << "\">"
       << escaped(content) << "</text>\n";
}

void SvgCanvas::tick_x(double x, double value) {
  line(x, kTop, x, kHeight - kBottom);
  text(x, kHeight - kBottom + 18, "middle", "#444", number(value));
}

void SvgCanvas::tick_y(double y, double value) {
  line(kLeft, y, kWidth - kRight, y);
  text(kLeft - 6, y + 4, "end", "#444", number(value));
}

void SvgCanvas::legend(std::size_t entry, const std::string& label, double right) {
  const double y = kTop + 8 + 16.0 * double(entry);
  svg_ << "<circle cx=\"" << kWidth - kRight - right << "\" cy=\"" << y << "\" r=\"4\" fill=\"" << colour(entry)
       << "\"/>\n";
  text(kWidth - kRight - right + 10, y + 4, "start", "#222", label);
}

std::string SvgCanvas::finish() {
  svg_ << "</svg>\n";
  return svg_.str();
}

std::string SvgCanvas::escaped(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : std::string(1, c);
  return out;
}

void DecadeAxis::fit(double least, double most) {
  low = int(std::floor(std::log10(least)));
  high = std::max(low + 1, int(std::ceil(std::log10(most))));
}

double DecadeAxis::place(double v) const {
  return (std::log10(v) - low) / (high - low);
}

}  // namespace sightline::study
