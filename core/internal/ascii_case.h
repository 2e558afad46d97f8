// Texts whose case does not count. Letters of ASCII alone have one, so that no locale matters. Internal: for the
// library's own sources.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>

namespace sightline::core {

constexpr char lower_case(char c) {
  return c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c;
}

inline std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = lower_case(c);
  return lower;
}

inline bool same_but_for_case(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](char x, char y) { return lower_case(x) == lower_case(y); });
}

}  // namespace sightline::core
