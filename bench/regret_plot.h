// Pairs of horizontal bars, one pair per trace, as SVG.
#pragma once

#include <algorithm>
#include <array>
#include <sstream>
#include <string>
#include <vector>

namespace sightline::bench {

/// Ratios >= 1 of two policies.
struct RegretBar {
  std::string label;
  double first, second;
};

/// Bars from 1 to `most`; longer ones are cut there, and all carry their value. Labels hold no markup characters.
inline std::string regret_plot(const std::string& title, const std::array<std::string, 2>& names,
                               const std::vector<RegretBar>& bars, double most = 4.0) {
  constexpr double kLabel = 330, kWidth = 960, kTop = 60, kRow = 24, kValue = 60;
  constexpr const char* kColours[2] = {"#1f6fb4", "#d9731a"};
  const double height = kTop + kRow * double(bars.size()) + 20;
  std::ostringstream svg;
  svg << "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" << kWidth << "\" height=\"" << height
      << "\" font-family=\"sans-serif\" font-size=\"11\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
      << "<text x=\"" << kWidth / 2 << "\" y=\"22\" text-anchor=\"middle\" font-size=\"14\">" << title << "</text>\n";
  const auto x_of = [&](double ratio) {
    return kLabel + (std::clamp(ratio, 1.0, most) - 1.0) / (most - 1.0) * (kWidth - kLabel - kValue);
  };
  for (double tick = 1.0; tick <= most; tick += 0.5)
    svg << "<line x1=\"" << x_of(tick) << "\" y1=\"" << kTop - 4 << "\" x2=\"" << x_of(tick) << "\" y2=\""
        << height - 20 << "\" stroke=\"#ddd\"/>\n<text x=\"" << x_of(tick) << "\" y=\"" << height - 6
        << "\" text-anchor=\"middle\" fill=\"#444\">" << tick << "</text>\n";
  for (int k = 0; k < 2; ++k)
    svg << "<text x=\"" << kLabel + 110 * k << "\" y=\"44\" fill=\"" << kColours[k] << "\">" << names[std::size_t(k)]
        << "</text>\n";
  svg.precision(4);
  for (std::size_t i = 0; i < bars.size(); ++i) {
    const double y = kTop + kRow * double(i);
    svg << "<text x=\"" << kLabel - 8 << "\" y=\"" << y + 14 << "\" text-anchor=\"end\">" << bars[i].label
        << "</text>\n";
    for (int k = 0; k < 2; ++k) {
      const double ratio = k == 0 ? bars[i].first : bars[i].second, top = y + 2 + 10 * k;
      svg << "<rect x=\"" << kLabel << "\" y=\"" << top << "\" width=\"" << x_of(ratio) - kLabel
          << "\" height=\"9\" fill=\"" << kColours[k] << "\"/>\n<text x=\"" << x_of(ratio) + 4 << "\" y=\"" << top + 8
          << "\" font-size=\"9\" fill=\"#444\">" << ratio << "</text>\n";
    }
  }
  svg << "</svg>\n";
  return svg.str();
}

}  // namespace sightline::bench
