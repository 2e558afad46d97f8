// Internal to the reader of OBJ and MTL: lines of a file, and what was noticed on them.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "sightline/importers/internal/import_job.h"
#include "sightline/importers/internal/text_encoding.h"
#include "sightline/importers/internal/text_scanner.h"

namespace sightline::importers::obj {

/// Lines end with LF, CR or both. One with a backslash at its end goes on in the next. A byte order mark is skipped.
class StatementLines {
 public:
  explicit StatementLines(std::string_view text)
      : begin_(text.data()), end_(begin_ + text.size()), at_(begin_ + (text.starts_with("\xef\xbb\xbf") ? 3 : 0)) {
    next_feed_ = find('\n');
    next_return_ = find('\r');
  }

  /// Takes the next line, which lasts until the next call. False at the end.
  bool next(std::string_view& line) {
    if (at_ == end_) return false;
    offset_ = std::uint64_t(at_ - begin_);
    number_ = taken_ + 1;
    line = take();
    if (goes_on(line)) line = joined(line);
    return true;
  }

  std::uint64_t number() const { return number_; }  ///< of the line, from 1
  std::uint64_t offset() const { return offset_; }  ///< of its begin
  double share() const { return begin_ == end_ ? 1.0 : double(at_ - begin_) / double(end_ - begin_); }

 private:
  /// From the present place on; the text's end where there is none.
  const char* find(char c) const {
    const void* const found = at_ == end_ ? nullptr : std::memchr(at_, c, std::size_t(end_ - at_));
    return found ? static_cast<const char*>(found) : end_;
  }

  std::string_view take() {
    // Each is searched for only when the former one is passed: files mostly have one of both alone.
    if (next_feed_ < at_) next_feed_ = find('\n');
    if (next_return_ < at_) next_return_ = find('\r');
    const char *const from = at_, *const stop = std::min(next_feed_, next_return_);
    at_ = stop == end_ ? end_ : stop + 1;
    if (stop == next_return_ && next_feed_ == stop + 1 && next_feed_ != end_) ++at_;
    ++taken_;
    return {from, stop};
  }

  /// A backslash in a comment ends the path of some folder, and names no further line. Neither does one after a word
  /// and before spaces.
  static bool goes_on(std::string_view line) {
    const std::size_t last = line.find_last_not_of(" \t");
    if (last == line.npos || line[last] != '\\') return false;
    if (last + 1 != line.size() && last > 0 && !is_space(line[last - 1])) return false;
    return line.find('#') == line.npos;
  }

  std::string_view joined(std::string_view line) {
    joined_.clear();
    for (bool more = true; more;) {
      more = goes_on(line);
      joined_ += more ? line.substr(0, line.find_last_of('\\')) : line;
      joined_ += ' ';
      if (!more || at_ == end_) break;
      line = take();
    }
    return joined_;
  }

  const char *begin_, *end_, *at_, *next_feed_, *next_return_;
  std::uint64_t number_ = 0, taken_ = 0, offset_ = 0;
  std::string joined_;
};

/// How often something was noticed, and where first.
struct Noticed {
  std::uint64_t count = 0, offset = 0, line = 0;
  std::string first;  ///< in quotes; may be empty

  void add(std::uint64_t at_offset, std::uint64_t at_line, std::string_view what = {}) {
    if (count++ > 0) return;
    offset = at_offset, line = at_line;
    if (!what.empty()) first = excerpt(what);
  }
  void add(const StatementLines& at, std::string_view what = {}) { add(at.offset(), at.number(), what); }

  /// One warning for all, or none.
  void warn(ImportJob& job, std::string_view what) const {
    if (count == 0) return;
    const std::string_view behind = first.empty() ? "" : ", the first ";
    job.warn(offset, fmt::format("line {}: {} {}{}{}", line, count, what, behind, first));
  }
};

/// Without what follows a '#' that stands by itself. Names such as "Material #25" stay whole.
inline std::string_view name_without_comment(std::string_view name) {
  for (std::size_t at = 0; (at = name.find('#', at)) != name.npos; ++at) {
    const bool alone = at + 1 == name.size() || is_space(name[at + 1]);
    if (alone && (at == 0 || is_space(name[at - 1]))) return trimmed(name.substr(0, at));
  }
  return name;
}

}  // namespace sightline::importers::obj
