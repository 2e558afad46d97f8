// How much random input tests try. What takes long only because it is repeated runs a tenth of the repetitions or less,
// whose seeds are the first of the long run's, unless SIGHTLINE_LONG=1 asks for all, as scripts/nightly.sh does.
#pragma once

#include <algorithm>
#include <cstdlib>
#include <string_view>

namespace sightline::tests {

/// Whether the environment asks for the long run.
inline bool long_run() {
  const char* value = std::getenv("SIGHTLINE_LONG");
  return value && std::string_view(value) == "1";
}

/// Repetitions of this run: `most` in a long one, a tenth of them otherwise, or another `part`, and at least one.
inline int repeated(int most, int part = 10) {
  return long_run() ? most : std::max(1, most / part);
}

}  // namespace sightline::tests
