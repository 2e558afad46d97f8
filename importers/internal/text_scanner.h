// Internal to the importers: words and numbers of text files, with the line they stand on.
#pragma once

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
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
    value = std::numeric_limits<double>::quiet_NaN();
    skip_space();
    if (at_ == end_) return Found::kEnd;
    const char* const from = at_ + (*at_ == '+' ? 1 : 0);
    const auto [stop, error] = std::from_chars(from, end_, value);
    if (error == std::errc::invalid_argument || (stop != end_ && !is_space(*stop))) {
      value = std::numeric_limits<double>::quiet_NaN();
      word();
      return Found::kOther;
    }
    if (error == std::errc::result_out_of_range) value = beyond_range({from, stop});
    at_ = stop;
    return Found::kNumber;
  }

  /// Takes the next word; empty at the end.
  std::string_view word() {
    skip_space();
    const char* const from = at_;
    while (at_ != end_ && !is_space(*at_)) ++at_;
    return {from, at_};
  }

  /// Takes the rest of the line, without space at either end.
  std::string_view rest_of_line() {
    const auto ends_line = [](char c) { return c == '\n' || c == '\r'; };
    while (at_ != end_ && is_space(*at_) && !ends_line(*at_)) ++at_;
    const char* const from = at_;
    at_ = std::find_if(at_, end_, ends_line);
    const char* stop = at_;
    while (stop != from && is_space(stop[-1])) --stop;
    return {from, stop};
  }

  std::uint64_t offset() const { return std::uint64_t(at_ - begin_); }
  double share() const { return begin_ == end_ ? 1.0 : double(at_ - begin_) / double(end_ - begin_); }

  /// Number of the scanner's present line, from 1. Counts on from the previous call, so repeated calls are cheap.
  std::uint64_t line() {
    line_ += std::uint64_t(std::count(counted_to_, at_, '\n'));
    counted_to_ = at_;
    return line_;
  }

 private:
  void skip_space() {
    while (at_ != end_ && is_space(*at_)) ++at_;
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
