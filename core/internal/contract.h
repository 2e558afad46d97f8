// Checks of the handles that callers pass. For core's own sources only: no header of an application depends on the
// option SIGHTLINE_CHECKED, so an application built without it can use a checked library.
#pragma once

#include <cassert>

#if SIGHTLINE_CHECKED

#include <cstdio>
#include <cstdlib>

namespace sightline::core {

[[noreturn]] inline void broken_contract(const char* function, const char* expected) {
  std::fprintf(stderr, "sightline: %s: expected %s\n", function, expected);
  std::abort();
}

}  // namespace sightline::core

/// Aborts with a line that says what was `expected`, a literal.
#define SIGHTLINE_CONTRACT(condition, expected) \
  ((condition) ? void() : ::sightline::core::broken_contract(__func__, expected))

#else

/// Asserts: nothing in builds with NDEBUG.
#define SIGHTLINE_CONTRACT(condition, expected) assert((condition) && "expected " expected)

#endif
