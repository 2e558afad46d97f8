// Numbers at the beginning of texts. Internal.
#pragma once

#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>

namespace sightline::query {

inline std::string_view trimmed(std::string_view text) {
  const auto blank = [](char c) { return c == ' ' || c == '\t'; };
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  return text;
}

/// The finite number that a text begins with, and what follows it, without blanks around; none where it begins with
/// something else.
inline std::optional<std::pair<double, std::string_view>> leading_number(std::string_view text) {
  text = trimmed(text);
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  double number = 0.0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), number);
  if (read.ec != std::errc() || !std::isfinite(number)) return std::nullopt;
  return std::pair(number, trimmed(text.substr(std::size_t(read.ptr - text.data()))));
}

}  // namespace sightline::query
