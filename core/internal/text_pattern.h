// Patterns that many short texts are compared with: wildcards and regular expressions. Internal: for the library's own
// sources.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "sightline/core/error.h"

namespace sightline::core {

/// A compiled pattern. Texts are UTF-8, of which a pattern sees the characters; a byte that is none
/// fits wildcards alone.
/// ASCII letters match regardless of case. All ways to match are followed side by side (K. Thompson, "Regular
/// expression search algorithm", 1968), so that time is at most that of the text times the pattern and no stack grows,
/// whatever both are.
class TextPattern {
 public:
  /// `*` stands for any characters, `?` for one, and all else for itself. The pattern fits a text as a whole.
  static TextPattern wildcards(std::string_view pattern);
  /// Fits where it matches any part of a text. Knows . ^ $ | ( ) (?: ) [ ] * + ? {n} {n,} {n,m}, \d \w \s with their
  /// opposites, and \ before any other character that is no letter or digit. Fails with the place, as a byte of the
  /// pattern, where it is something else, and where it would take too many steps.
  static Expected<TextPattern> regular(std::string_view pattern);

  bool fits(std::string_view text) const;

 private:
  friend class PatternCompiler;

  struct Range {
    char32_t first, last;
  };
  struct Set {
    std::vector<Range> ranges;
    bool negated = false;
    bool contains(char32_t c) const;
  };
  enum class Op : std::uint8_t { kSet, kFork, kBegin, kEnd };
  /// A step of the machine. Steps that take no character lead to the steps that lie `next` and, of a fork, `other`
  /// further.
  struct Step {
    Op op;
    std::int32_t next = 1, other = 1;
    std::uint32_t set = 0;
  };
  class Run;

  std::vector<Step> steps_;  // behind the last one the text fits
  std::vector<Set> sets_;
};

}  // namespace sightline::core
