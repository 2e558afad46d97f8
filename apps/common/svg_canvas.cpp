#include "sightline/apps/common/svg_canvas.h"

#include "sightline/apps/common/markup.h"

namespace sightline::apps {

SvgCanvas::SvgCanvas(double width, double height, int font_size) {
  svg_ << "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" << width << "\" height=\"" << height
       << "\" viewBox=\"0 0 " << width << ' ' << height << "\" font-family=\"sans-serif\" font-size=\"" << font_size
       << "\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n";
}

const char* SvgCanvas::colour(std::size_t series) {
  static constexpr std::array kColours{"#1f6fb4", "#d9731a", "#2c9c3f", "#c23b3b", "#7b52ab",
                                       "#7f5a46", "#d65fa8", "#222222", "#17becf"};
  return kColours[series % kColours.size()];
}

void SvgCanvas::text(double x, double y, const char* anchor, const char* fill, std::string_view content, int size) {
  svg_ << "<text x=\"" << x << "\" y=\"" << y << "\" text-anchor=\"" << anchor << "\" fill=\"" << fill << '"';
  if (size > 0) svg_ << " font-size=\"" << size << '"';
  svg_ << '>' << escaped(content) << "</text>\n";
}

void SvgCanvas::line(double x1, double y1, double x2, double y2, const char* stroke, double width) {
  svg_ << "<line x1=\"" << x1 << "\" y1=\"" << y1 << "\" x2=\"" << x2 << "\" y2=\"" << y2 << "\" stroke=\"" << stroke
       << "\" stroke-width=\"" << width << "\"/>\n";
}

void SvgCanvas::rectangle(double x, double y, double width, double height, const char* fill) {
  svg_ << "<rect x=\"" << x << "\" y=\"" << y << "\" width=\"" << width << "\" height=\"" << height << "\" fill=\""
       << fill << "\"/>\n";
}

void SvgCanvas::circle(double x, double y, double radius, const char* fill, std::string_view hover) {
  svg_ << "<circle cx=\"" << x << "\" cy=\"" << y << "\" r=\"" << radius << "\" fill=\"" << fill << '"';
  if (hover.empty())
    svg_ << "/>\n";
  else
    svg_ << "><title>" << escaped(hover) << "</title></circle>\n";
}

void SvgCanvas::polyline(const std::vector<std::array<double, 2>>& points, const char* stroke, double width,
                         bool dashed) {
  svg_ << "<polyline fill=\"none\" stroke=\"" << stroke << "\" stroke-width=\"" << width << '"';
  if (dashed) svg_ << " stroke-dasharray=\"4 3\"";
  svg_ << " points=\"";
  for (const auto& [x, y] : points) svg_ << x << ',' << y << ' ';
  svg_ << "\"/>\n";
}

std::string SvgCanvas::finish() && {
  svg_ << "</svg>\n";
  return std::move(svg_).str();
}

std::string short_number(double value, int significant_digits) {
  std::ostringstream text;
  text.precision(significant_digits);
  text << value;
  return text.str();
}

}  // namespace sightline::apps
