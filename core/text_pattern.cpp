#include "sightline/core/internal/text_pattern.h"

#include <algorithm>
#include <string>
#include <utility>

#include "sightline/core/internal/ascii_case.h"

namespace sightline::core {
namespace {

constexpr char32_t kNoCharacter = 0xffffffff, kLastCharacter = 0x10ffff;
constexpr std::size_t kMostSteps = 20'000;
constexpr int kMostNested = 100, kMostRepeats = 1000;

/// Takes the first character of UTF-8 text, or one byte that is none.
char32_t take_character(std::string_view& text) {
  const auto lead = static_cast<unsigned char>(text.front());
  const std::size_t length = lead < 0x80   ? 1
                             : lead < 0xc2 ? 0
                             : lead < 0xe0 ? 2
                             : lead < 0xf0 ? 3
                             : lead < 0xf5 ? 4
                                           : 0;
  char32_t c = length == 1 ? lead : lead & (0x7fu >> length);
  bool valid = length > 0 && length <= text.size();
  for (std::size_t i = 1; valid && i < length; ++i) {
    const auto more = static_cast<unsigned char>(text[i]);
    valid = (more & 0xc0) == 0x80;
    c = c << 6 | (more & 0x3f);
  }
  text.remove_prefix(valid ? length : 1);
  return valid ? c : kNoCharacter;
}

}  // namespace

bool TextPattern::Set::contains(char32_t c) const {
  const auto in = [&](char32_t x) {
    return std::any_of(ranges.begin(), ranges.end(), [x](const Range& r) { return r.first <= x && x <= r.last; });
  };
  if (c == kNoCharacter) return !negated && in(c);
  const bool upper = c >= 'A' && c <= 'Z', lower = c >= 'a' && c <= 'z';
  return (in(c) || ((upper || lower) && in(c ^ 0x20))) != negated;
}

// --- compiling -------------------------------------------------------------------------------------------------------

/// Makes steps of a pattern by recursive descent.
class PatternCompiler {
 public:
  explicit PatternCompiler(std::string_view pattern) : all_(pattern), rest_(pattern) {}

  TextPattern wildcards() {
    Steps steps{{Op::kBegin}};
    while (!rest_.empty()) {
      const char32_t c = take_character(rest_);
      Steps one{c == '*' || c == '?' ? any(kNoCharacter) : literal(c)};
      append(steps, c == '*' ? repeated(one, 0, -1) : one);
    }
    steps.push_back({Op::kEnd});
    return finish(std::move(steps));
  }

  Expected<TextPattern> regular() {
    Steps steps = alternatives(0);
    if (error_.empty() && !rest_.empty()) refuse("an opening parenthesis is missing");
    if (!error_.empty()) return fail("regular expression, after byte " + std::to_string(at_) + ": " + error_);
    return finish(std::move(steps));
  }

 private:
  using Op = TextPattern::Op;
  using Set = TextPattern::Set;
  using Steps = std::vector<TextPattern::Step>;

  TextPattern finish(Steps steps) {
    pattern_.steps_ = std::move(steps);
    return std::move(pattern_);
  }
  void refuse(const char* why) {
    if (error_.empty()) error_ = why, at_ = all_.size() - rest_.size();
  }
  bool take(char c) {
    if (rest_.empty() || rest_.front() != c) return false;
    rest_.remove_prefix(1);
    return true;
  }

  static void append(Steps& to, const Steps& more) { to.insert(to.end(), more.begin(), more.end()); }
  TextPattern::Step step_of(Set set) {
    pattern_.sets_.push_back(std::move(set));
    return {Op::kSet, 1, 1, std::uint32_t(pattern_.sets_.size() - 1)};
  }
  TextPattern::Step any(char32_t last) { return step_of({{{0, last}}}); }
  TextPattern::Step literal(char32_t c) { return step_of({{{c, c}}}); }

  /// `most` < 0: any number of times.
  Steps repeated(const Steps& one, int least, int most) {
    const int copies = std::max({least, most, 1});
    if (one.size() * std::size_t(copies) > kMostSteps) return refuse("it repeats too much"), Steps();
    const auto size = std::int32_t(one.size());
    Steps all;
    for (int i = 0; i < least; ++i) append(all, one);
    for (int i = least; i < most; ++i) {
      all.push_back({Op::kFork, 1, size + 1});
      append(all, one);
    }
    if (most >= 0) return all;
    all.push_back({Op::kFork, 1, size + 2});
    append(all, one);
    all.push_back({Op::kFork, -(size + 1), -(size + 1)});
    return all;
  }

  Steps alternatives(int nested) {
    if (nested > kMostNested) return refuse("too many parentheses within one another"), Steps();
    Steps all = sequence(nested);
    while (error_.empty() && take('|')) {
      const Steps more = sequence(nested);
      const auto first = std::int32_t(all.size()), second = std::int32_t(more.size());
      all.insert(all.begin(), {Op::kFork, 1, first + 2});
      all.push_back({Op::kFork, second + 1, second + 1});
      append(all, more);
      if (all.size() > kMostSteps) refuse("it takes too many steps");
    }
    return all;
  }

  Steps sequence(int nested) {
    Steps all;
    while (error_.empty() && !rest_.empty() && rest_.front() != '|' && rest_.front() != ')') {
      Steps one = atom(nested);
      while (error_.empty() && repeats(one)) {
      }
      append(all, one);
      if (all.size() > kMostSteps) refuse("it takes too many steps");
    }
    return all;
  }

  Steps atom(int nested) {
    if (take('(')) {
      if (take('?') && !take(':')) refuse("expected (?: after a parenthesis with a question mark");
      Steps inner = alternatives(nested + 1);
      if (error_.empty() && !take(')')) refuse("a closing parenthesis is missing");
      return inner;
    }
    if (take('[')) return {step_of(brackets())};
    if (take('.')) return {any(kLastCharacter)};
    if (take('^')) return {{Op::kBegin}};
    if (take('$')) return {{Op::kEnd}};
    if (take('\\')) return {step_of(escaped())};
    if (rest_.front() == '*' || rest_.front() == '+' || rest_.front() == '?') refuse("nothing to repeat");
    const char32_t c = take_character(rest_);
    if (c == kNoCharacter) refuse("no UTF-8");
    return {literal(c)};
  }

  /// Takes a repetition of what stands before, where there is one.
  bool repeats(Steps& one) {
    int least = 0, most = -1;
    const std::string_view before = rest_;
    if (take('+')) {
      least = 1;
    } else if (take('?')) {
      most = 1;
    } else if (take('{')) {
      if (!counts(least, most)) return rest_ = before, refuse("expected {n}, {n,} or {n,m}, of 1000 at most"), false;
    } else if (!take('*')) {
      return false;
    }
    (void)take('?');  // whether the shortest match is preferred makes no difference to whether there is one
    one = repeated(one, least, most);
    return true;
  }
  bool counts(int& least, int& most) {
    const auto number = [&](int& n) {
      n = 0;
      const std::size_t before = rest_.size();
      for (; !rest_.empty() && rest_.front() >= '0' && rest_.front() <= '9' && n <= kMostRepeats;
           rest_.remove_prefix(1))
        n = 10 * n + (rest_.front() - '0');
      return rest_.size() < before && n <= kMostRepeats;
    };
    if (!number(least)) return false;
    most = least;
    if (take(',') && !number(most)) most = -1;
    return take('}') && (most < 0 || most >= least);
  }

  /// The characters after a backslash.
  Set escaped() {
    if (rest_.empty()) return refuse("nothing after \\"), Set();
    const char32_t c = take_character(rest_);
    const bool negated = c == 'D' || c == 'W' || c == 'S';
    switch (c) {
      case 'd':
      case 'D':
        return {{{'0', '9'}}, negated};
      case 'w':
      case 'W':
        return {{{'0', '9'}, {'a', 'z'}, {'_', '_'}}, negated};
      case 's':
      case 'S':
        return {{{' ', ' '}, {'\t', '\r'}}, negated};
      case 't':
        return {{{'\t', '\t'}}};
      case 'n':
        return {{{'\n', '\n'}}};
      default:
        break;
    }
    if ((c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == kNoCharacter)
      refuse("unknown after \\; expected d, w, s, their capitals, or no letter");
    return {{{c, c}}};
  }

  Set brackets() {
    Set set;
    const bool negated = take('^');
    for (bool first = true; first || !take(']'); first = false) {
      if (rest_.empty()) return refuse("a closing ] is missing"), Set();
      if (take('\\')) {
        const Set more = escaped();
        if (more.negated) refuse("expected no \\D, \\W or \\S within []");
        set.ranges.insert(set.ranges.end(), more.ranges.begin(), more.ranges.end());
        continue;
      }
      const char32_t from = take_character(rest_);
      char32_t to = from;
      if (rest_.size() > 1 && rest_.front() == '-' && rest_[1] != ']') {
        rest_.remove_prefix(1);
        (void)take('\\');
        to = take_character(rest_);
      }
      if (from == kNoCharacter || to == kNoCharacter || from > to)
        refuse("a range within [] that begins after its end");
      set.ranges.push_back({from, to});
    }
    set.negated = negated;
    return set;
  }

  std::string_view all_, rest_;
  TextPattern pattern_;
  std::string error_;
  std::size_t at_ = 0;
};

TextPattern TextPattern::wildcards(std::string_view pattern) {
  return PatternCompiler(pattern).wildcards();
}

Expected<TextPattern> TextPattern::regular(std::string_view pattern) {
  return PatternCompiler(pattern).regular();
}

// --- matching --------------------------------------------------------------------------------------------------------

/// The steps that wait for a character, of all ways to match so far.
class TextPattern::Run {
 public:
  explicit Run(const TextPattern& pattern) : pattern_(pattern), seen_(pattern.steps_.size() + 1, 0) {}

  bool fits(std::string_view text) {
    const bool anchored = !pattern_.steps_.empty() && pattern_.steps_.front().op == Op::kBegin;
    for (bool begin = true;; begin = false) {
      if (begin || !anchored) follow(0, begin, text.empty());
      if (fits_) return true;
      if (text.empty() || (anchored && waiting_.empty())) return false;
      const char32_t c = take_character(text);
      before_.clear();
      before_.swap(waiting_);
      ++time_;
      for (const std::int32_t step : before_)
        if (pattern_.sets_[pattern_.steps_[std::size_t(step)].set].contains(c)) follow(step + 1, false, text.empty());
    }
  }

 private:
  /// Adds the steps that wait for a character and can be reached from one without any.
  void follow(std::int32_t from, bool begin, bool end) {
    open_.push_back(from);
    while (!open_.empty()) {
      const std::int32_t at = open_.back();
      open_.pop_back();
      if (std::exchange(seen_[std::size_t(at)], time_) == time_) continue;
      if (std::size_t(at) == pattern_.steps_.size()) {
        fits_ = true;
        continue;
      }
      const Step& step = pattern_.steps_[std::size_t(at)];
      if (step.op == Op::kSet) {
        waiting_.push_back(at);
        continue;
      }
      if ((step.op == Op::kBegin && !begin) || (step.op == Op::kEnd && !end)) continue;
      open_.push_back(at + step.next);
      if (step.op == Op::kFork) open_.push_back(at + step.other);
    }
  }

  const TextPattern& pattern_;
  std::vector<std::uint64_t> seen_;  // when a step was reached last
  std::uint64_t time_ = 1;
  std::vector<std::int32_t> waiting_, before_, open_;
  bool fits_ = false;
};

bool TextPattern::fits(std::string_view text) const {
  return Run(*this).fits(text);
}

}  // namespace sightline::core
