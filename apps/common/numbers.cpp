#include "sightline/apps/common/numbers.h"

#include <cmath>
#include <cstdio>

namespace sightline::apps {

std::string grouped(std::int64_t number) {
  std::string text = std::to_string(number);
  for (int at = int(text.size()) - 3; at > (number < 0 ? 1 : 0); at -= 3) text.insert(std::size_t(at), ",");
  return text;
}

std::string vector_text(const core::dvec3& v) {
  char text[100];
  std::snprintf(text, sizeof text, "%.3f  %.3f  %.3f", v.x + 0.0, v.y + 0.0, v.z + 0.0);  // no -0
  return text;
}

std::string length_text(double metres) {
  char text[40];
  const bool small = std::abs(metres) < 0.01;
  std::snprintf(text, sizeof text, small ? "%.2f mm" : "%.3f m", small ? 1e3 * metres : metres);
  return text;
}

}  // namespace sightline::apps
