#include "sightline/apps/common/arguments.h"

#include <cmath>
#include <cstdio>

#include "sightline/core/internal/atomic_file.h"
#include "sightline/core/internal/platform/files.h"

namespace sightline::apps {

core::Expected<std::array<int, 2>> parse_size(const std::string& text) {
  int width = 0, height = 0, used = 0;
  const bool parsed = std::sscanf(text.c_str(), "%5dx%5d%n", &width, &height, &used) == 2;
  if (!parsed || used != int(text.size()) || width < 1 || height < 1 || width > 16384 || height > 16384)
    return core::fail("expected WIDTHxHEIGHT between 1 and 16384, found \"" + text + "\"");
  return std::array<int, 2>{width, height};
}

core::Expected<core::dvec3> parse_vector(const std::string& text) {
  core::dvec3 v(0.0);
  int used = 0;
  const bool parsed = std::sscanf(text.c_str(), "%lf,%lf,%lf%n", &v.x, &v.y, &v.z, &used) == 3;
  if (!parsed || used != int(text.size()) || !std::isfinite(v.x) || !std::isfinite(v.y) || !std::isfinite(v.z))
    return core::fail("expected X,Y,Z, three finite numbers, found \"" + text + "\"");
  return v;
}

core::Expected<core::dvec3> parse_direction(const std::string& text) {
  auto direction = parse_vector(text);
  if (direction && *direction == core::dvec3(0.0)) return core::fail("expected a direction, found \"" + text + "\"");
  return direction;
}

core::Expected<double> parse_finite(const std::string& text) {
  double value = 0.0;
  int used = 0;
  const bool parsed = std::sscanf(text.c_str(), "%lf%n", &value, &used) == 1;
  if (!parsed || used != int(text.size()) || !std::isfinite(value))
    return core::fail("expected a finite number, found \"" + text + "\"");
  return value;
}

namespace {

core::Expected<std::string> parse_name(const std::string& text, std::string_view extension) {
  return core::expect_extension(core::platform::path_of(text), extension).map([&] { return text; });
}

}  // namespace

core::Expected<std::string> parse_png_name(const std::string& text) {
  return parse_name(text, ".png");
}

core::Expected<std::string> parse_pfm_name(const std::string& text) {
  return parse_name(text, ".pfm");
}

core::Expected<std::string> parse_svg_name(const std::string& text) {
  return parse_name(text, ".svg");
}

}  // namespace sightline::apps
