#include "sightline/apps/common/numbers.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace sightline::apps {

namespace {

/// Digits with a comma between each three from the end.
std::string with_commas(std::string digits) {
  for (int at = int(digits.size()) - 3; at > 0; at -= 3) digits.insert(std::size_t(at), ",");
  return digits;
}

}  // namespace

std::string grouped(std::int64_t number) {
  const std::string text = std::to_string(number);
  return number < 0 ? "-" + with_commas(text.substr(1)) : with_commas(text);
}

std::string vector_text(const core::dvec3& v) {
  return fmt::format("{:.3f}  {:.3f}  {:.3f}", v.x + 0.0, v.y + 0.0, v.z + 0.0);  // no -0
}

std::string bytes_text(std::uint64_t bytes) {
  constexpr std::uint64_t kMostKilobytes = 100'000, kMostMegabytes = 10'000'000'000;
  if (bytes < kMostKilobytes) return fmt::format("{:.1f} kB", double(bytes) / 1e3);
  if (bytes < kMostMegabytes) return fmt::format("{:.1f} MB", double(bytes) / 1e6);
  return fmt::format("{:.1f} GB", double(bytes) / 1e9);
}

std::string length_text(double metres) {
  return std::abs(metres) < 0.01 ? fmt::format("{:.2f} mm", 1e3 * metres) : fmt::format("{:.3f} m", metres);
}

std::string LengthFormat::number(double metres) const {
  const double value = metres * per_metre();
  std::string digits = fmt::format("{:.{}f}", std::abs(value), decimals == kTrimmed ? 6 : decimals);
  if (decimals == kTrimmed) digits.erase(digits.find_last_not_of("0") + 1);
  if (digits.back() == '.') digits.pop_back();
  const std::size_t point = std::min(digits.find('.'), digits.size());
  const bool zero = digits.find_first_not_of("0.") == std::string::npos;  // no -0
  return (value < 0.0 && !zero ? "-" : "") + with_commas(digits.substr(0, point)) + digits.substr(point);
}

std::string LengthFormat::plain(double metres) const {
  std::string digits = number(metres);
  std::erase(digits, ',');
  return digits;
}

double LengthFormat::per_metre() const {
  return units == Units::kMillimetres ? 1e3 : units == Units::kFeet ? 1.0 / 0.3048 : 1.0;
}

std::string LengthFormat::text(double metres) const {
  return number(metres) + " " + unit();
}

std::string LengthFormat::text(const core::dvec3& place) const {
  if (decimals == kTrimmed) return vector_text(place);
  return number(place.x) + "  " + number(place.y) + "  " + number(place.z);
}

LengthFormat length_format(Units chosen, double size, bool plant) {
  constexpr double kPlant = 10.0;  // metres
  int decimals = 0;                // of millimetres
  if (!plant && !(size > kPlant)) decimals = size > 1.0 ? 1 : size > 0.1 ? 2 : 3;
  if (chosen == Units::kAutomatic) chosen = Units::kMillimetres;
  return {chosen, chosen == Units::kMillimetres ? decimals : decimals + 3};
}

std::string unbroken(const std::string& text) {
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool digit_before = i > 0 && text[i - 1] >= '0' && text[i - 1] <= '9';
    const bool joins = text[i] == ' ' && digit_before && i + 1 < text.size() && text[i + 1] != ' ';
    result += joins ? "\u00a0" : std::string(1, text[i]);
  }
  return result;
}

}  // namespace sightline::apps
