#include "sightline/apps/common/arguments.h"

#include <cmath>
#include <cstdio>
#include <filesystem>

#include "sightline/importers/internal/extension.h"

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

core::Expected<std::string> parse_png_name(const std::string& text) {
  const std::string extension = importers::lower_case_extension(text);
  for (const char* other : {".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".gif", ".webp", ".svg", ".pdf", ".exr", ".tga"})
    if (extension == other)
      return core::fail("images are written as PNG: expected a name such as image.png, found \"" + text + "\"");
  return text;
}

std::string shell_word(const std::string& word) {
  constexpr const char* kPlain = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_./,:=+-";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) return word;
  std::string out = "'";
  for (const char c : word) out += c == '\'' ? "'\\''" : std::string(1, c);
  return out + "'";
}

}  // namespace sightline::apps
