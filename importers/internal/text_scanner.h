// Internal to the importers: words and numbers of text files, with the line they stand on.
#pragma once

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>

namespace sightline::importers {

/// White space of the C locale.
constexpr bool is_space(char c) {
  return c == ' ' || (c >= '\t' && c <= '\r');
}

/// A line without the spaces, tabs and carriage returns at its ends.
inline std::string_view trimmed(std::string_view line) {
  constexpr std::string_view kBlank = " \t\r";
  const std::size_t begin = line.find_first_not_of(kBlank);
  return begin == line.npos ? std::string_view() : line.substr(begin, line.find_last_not_of(kBlank) + 1 - begin);
}

/// Three bytes with which editors mark a text as UTF-8.
inline constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";

inline bool begins_with_mark(std::span<const std::byte> text) {
  return std::string_view(reinterpret_cast<const char*>(text.data()), text.size()).starts_with(kByteOrderMark);
}

/// A word of a file for a message. Files may hold anything, messages are printable.
inline std::string shown_word(std::string_view word) {
  std::string out(word.substr(0, 40));
  for (char& c : out)
    if (c < ' ' || c > '~') c = '?';
  return "'" + out + "'";
}

class TextScanner {
 public:
  enum class Found : std::uint8_t { kNumber, kOther, kEnd };

  explicit TextScanner(std::span<const std::byte> text)
      : begin_(reinterpret_cast<const char*>(text.data())),
        at_(begin_),
        end_(begin_ + text.size()),
        counted_to_(begin_) {}

  /// Takes the next word as a number in the C locale: decimal, "inf" or "nan", a leading + allowed. A number beyond the
  /// range of double is infinite. A word that is not a number is taken, too, and gives NaN.
  Found number(double& value) {
    skip_space();
    return number_here(value);
  }

  /// Reads the next word of this line as a number: kEnd where the line has none.
  Found number_in_line(double& value) {
    if (!at_line_end()) return number_here(value);
    value = std::numeric_limits<double>::quiet_NaN();
    return Found::kEnd;
  }

  /// Takes the next word; empty at the end.
  std::string_view word() {
    skip_space();
    const char* const from = at_;
    while (at_ != end_ && !is_space(*at_)) ++at_;
    return between(from, at_);
  }

  /// Takes the rest of the line, without space at either end.
  std::string_view rest_of_line() {
    at_line_end();
    const char* const from = at_;
    at_ = std::find_if(at_, end_, ends_line);
    const char* stop = at_;
    while (stop != from && is_space(stop[-1])) --stop;
    return between(from, stop);
  }

  /// Takes the next word of this line; empty where the line has none.
  std::string_view word_in_line() { return at_line_end() ? std::string_view() : word(); }

  /// Passes spaces and tabs. True when nothing else is left of the line.
  bool at_line_end() {
    while (at_ != end_ && is_blank(*at_)) ++at_;
    return at_ == end_ || ends_line(*at_);
  }
  /// Passes a line's end, LF, CR LF or CR. False at the end of the text.
  bool next_line() {
    if (at_ == end_) return false;
    if (*at_++ == '\r' && at_ != end_ && *at_ == '\n') ++at_;
    return true;
  }
  /// Returns what is left of the text, and takes nothing.
  std::string_view rest() const { return between(at_, end_); }
  void pass(std::size_t bytes) { at_ += bytes; }
  /// Goes back to what rest() was, if line() was not asked behind the line's end.
  void back_to(std::string_view rest) { counted_to_ = std::min(counted_to_, at_ = rest.data()); }

  std::uint64_t offset() const { return std::uint64_t(at_ - begin_); }
  double share() const { return begin_ == end_ ? 1.0 : double(at_ - begin_) / double(end_ - begin_); }

  /// Number of the scanner's present line, from 1. Counts on from the previous call, so repeated calls are cheap.
  std::uint64_t line() {
    line_ += std::uint64_t(std::count(counted_to_, at_, '\n'));
    counted_to_ = at_;
    return line_;
  }

 private:
  static std::string_view between(const char* from, const char* to) { return {from, std::size_t(to - from)}; }
  static constexpr bool is_digit(char c) { return c >= '0' && c <= '9'; }
  static constexpr bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }
  static constexpr bool ends_line(char c) { return c == '\n' || c == '\r'; }
  void skip_space() {
    while (at_ != end_ && is_space(*at_)) ++at_;
  }
  /// Takes a decimal of at most 15 digits, which are exact in a double, as their power of ten is. So one division
  /// rounds as from_chars() does, in half the time. False, with nothing taken, for all other words.
  bool short_decimal(double& value) {
    constexpr int kMostDigits = 15;
    constexpr double kPowers[kMostDigits + 1] = {1e0, 1e1, 1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                                 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15};
    const char* at = at_ + (*at_ == '-' ? 1 : 0);
    std::uint64_t mantissa = 0;
    int digits = 0, behind_point = 0;
    for (; at != end_ && is_digit(*at) && digits <= kMostDigits; ++at, ++digits)
      mantissa = 10 * mantissa + std::uint64_t(*at - '0');
    if (at != end_ && *at == '.')
      for (++at; at != end_ && is_digit(*at) && digits <= kMostDigits; ++at, ++digits, ++behind_point)
        mantissa = 10 * mantissa + std::uint64_t(*at - '0');
    if (digits == 0 || digits > kMostDigits || (at != end_ && !is_space(*at))) return false;
    const double magnitude = behind_point > 0 ? double(mantissa) / kPowers[behind_point] : double(mantissa);
    value = *at_ == '-' ? -magnitude : magnitude;
    at_ = at;
    return true;
  }
  Found number_here(double& value) {
    value = std::numeric_limits<double>::quiet_NaN();
    if (at_ == end_) return Found::kEnd;
    if (short_decimal(value)) return Found::kNumber;
    const char* const from = at_ + (*at_ == '+' ? 1 : 0);
    const auto [stop, error] = std::from_chars(from, end_, value);
    if (error == std::errc::invalid_argument || (stop != end_ && !is_space(*stop))) {
      value = std::numeric_limits<double>::quiet_NaN();
      word();
      return Found::kOther;
    }
    if (error == std::errc::result_out_of_range) value = beyond_range(between(from, stop));
    at_ = stop;
    return Found::kNumber;
  }
  static double beyond_range(std::string_view word) {
    const bool negative = word.front() == '-';
    const bool tiny = word.find('-', 1) != std::string_view::npos || word[negative ? 1 : 0] == '0';
    const double magnitude = tiny ? 0.0 : std::numeric_limits<double>::infinity();
    return negative ? -magnitude : magnitude;
  }

  const char *begin_, *at_, *end_, *counted_to_;
  std::uint64_t line_ = 1;
};

}  // namespace sightline::importers
