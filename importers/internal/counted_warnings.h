// Internal to the importers: warnings about what a file does again and again, such as a misspelt keyword in each facet.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "sightline/importers/internal/import_job.h"

namespace sightline::importers {

/// One warning for each kind of thing, with the place of the first and how often it came. So a file that bends the
/// specification throughout does not drown what else is to be said about it.
class CountedWarnings {
 public:
  /// `what`: a literal, which names the kind. `where()` gives the place as text and is asked the first time alone.
  template <class Where>
  void add(std::string_view what, std::uint64_t offset, Where&& where) {
    for (Kind& kind : kinds_)
      if (kind.what == what) {
        ++kind.count;
        return;
      }
    kinds_.push_back({what, offset, where(), 1});
  }
  bool empty() const { return kinds_.empty(); }

  void list(ImportJob& job) const {
    for (const Kind& kind : kinds_)
      job.warn(kind.offset, fmt::format("{}: {}{}", kind.where, kind.what,
                                        kind.count > 1 ? fmt::format(" ({} times)", kind.count) : ""));
  }

 private:
  struct Kind {
    std::string_view what;
    std::uint64_t offset;  // of the first
    std::string where;
    std::uint64_t count;
  };
  std::vector<Kind> kinds_;
};

}  // namespace sightline::importers
