#include "sightline/importers/cad/internal/iges_repair.h"

#include <algorithm>
#include <charconv>
#include <span>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "sightline/importers/internal/text_encoding.h"
#include "sightline/importers/internal/text_scanner.h"

namespace sightline::importers {
namespace {

using Lines = std::vector<std::string_view>;

// Columns of a line, from 0.
constexpr std::size_t kParameters = 64, kLetter = 72, kField = 8;

struct Delimiters {
  char parameter = ',', record = ';';
};

template <class T>
std::optional<T> number_in(std::string_view text) {
  text = trimmed(text);
  T value{};
  const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), value);
  return failed == std::errc() && end == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

/// A line's number in a field of eight columns.
std::optional<std::size_t> field(std::string_view line, std::size_t index) {
  return number_in<std::size_t>(line.substr(kField * index, kField));
}

/// "1H,,1H;," at the begin of the global section names other delimiters than the usual ones.
Delimiters delimiters_of(const Lines& global) {
  Delimiters found;
  if (global.empty()) return found;
  std::string_view text = global[0];
  if (text.starts_with("1H") && text.size() > 3) {
    found.parameter = text[2];
    text.remove_prefix(4);
  } else {
    text.remove_prefix(std::min<std::size_t>(1, text.size()));
  }
  if (text.starts_with("1H") && text.size() > 2) found.record = text[2];
  return found;
}

/// The parameters of an entity as they are written.
struct Parameters {
  std::vector<std::string> texts;
  std::size_t end = 0;  ///< behind them, and their record delimiter
  bool whole = false;   ///< there is one
};

/// Where a string such as "5HPlate" begins and ends; nothing for other parameters.
std::optional<std::pair<std::size_t, std::size_t>> string_at(std::string_view text, std::size_t at) {
  const std::size_t begin = text.find_first_not_of(' ', at);
  if (begin == text.npos) return {};
  const std::size_t letter = text.find_first_not_of("0123456789", begin);
  if (letter == begin || letter == text.npos || text[letter] != 'H') return {};
  const auto length = number_in<std::size_t>(text.substr(begin, letter - begin));
  if (!length || *length > text.size() - letter - 1) return {};
  return std::pair(begin, letter + 1 + *length);
}

Parameters parameters_of(std::string_view text, Delimiters by) {
  Parameters found;
  while (found.end < text.size() && !found.whole) {
    const auto string = string_at(text, found.end);
    std::size_t at = string ? string->second : found.end;
    while (at < text.size() && text[at] != by.parameter && text[at] != by.record) ++at;
    if (at == text.size()) break;
    found.texts.emplace_back(string ? text.substr(string->first, string->second - string->first)
                                    : trimmed(text.substr(found.end, at - found.end)));
    found.whole = text[at] == by.record;
    found.end = at + 1;
  }
  return found;
}

/// Entity 126 or 128: a spline curve or surface.
struct Spline {
  std::vector<std::size_t> limits;  ///< where its first and last value of each direction are among the parameters
  std::size_t ranges = 0;           ///< where these values are told again
  std::size_t end = 0;              ///< behind all parameters of its own
};

/// Nothing for other entities. `ranges` lies beyond the parameters of one that lacks more.
std::optional<Spline> spline_of(const std::vector<std::string>& texts) {
  const std::size_t beyond = texts.size() + 1;
  const auto number = [&](std::size_t i) {
    return (i < texts.size() ? number_in<std::size_t>(texts[i]) : std::nullopt).value_or(beyond);
  };
  const bool surface = number(0) == 128;
  if (!surface && number(0) != 126) return {};
  Spline found;
  std::size_t at = surface ? 10 : 7, poles = 1;
  for (std::size_t i = 1; i <= (surface ? 2u : 1u); ++i) {
    const std::size_t upper = number(i), degree = number(i + (surface ? 2 : 1));
    if (upper >= beyond || degree > upper) return Spline{{}, beyond, beyond};
    found.limits.insert(found.limits.end(), {at + degree, at + upper + 1});
    at += upper + degree + 2;
    poles *= upper + 1;
  }
  constexpr std::size_t kNormal = 3;                        // of a plane curve
  found.ranges = poles > beyond ? beyond : at + 4 * poles;  // behind weights and points
  found.end = found.ranges + found.limits.size() + (surface ? 0 : kNormal);
  return found;
}

/// Gives a spline the parameter ranges that it lacks, from its knots. False where nothing is to be done.
bool complete_ranges(std::vector<std::string>& texts, const Spline& spline) {
  bool changed = texts.size() < spline.end;
  texts.resize(std::max(texts.size(), spline.end));
  for (std::size_t i = spline.ranges; i < spline.end; ++i) {
    if (!texts[i].empty()) continue;
    const std::size_t range = i - spline.ranges;
    texts[i] = range < spline.limits.size() ? texts[spline.limits[range]] : "0.";
    changed = true;
  }
  return changed;
}

class IgesRepair {
 public:
  IgesRepair(ImportJob& job, std::string_view text) : job_(job), names_(job) {
    while (!text.empty()) {
      const std::size_t end = std::min(text.find('\n'), text.size());
      const std::string_view line = trimmed_end(text.substr(0, end));
      text.remove_prefix(std::min(end + 1, text.size()));
      if (line.size() <= kLetter) continue;
      switch (line[kLetter]) {
        case 'S':
        case 'G':
          (line[kLetter] == 'G' ? global_ : start_).push_back(line);
          break;
        case 'D':
          directory_.push_back(line);
          break;
        case 'P':
          parameters_.push_back(line);
          break;
        default:
          break;
      }
    }
    by_ = delimiters_of(global_);
  }

  std::optional<std::string> run() {
    if (start_.empty() || directory_.empty() || directory_.size() % 2 != 0) return {};
    for (std::size_t i = 0; i < directory_.size(); i += 2)
      if (!add_entity(directory_[i], directory_[i + 1])) return {};
    if (!changed_ && count_ == parameters_.size()) return {};
    std::string all;
    for (const Lines* section : {&start_, &global_})
      for (const std::string_view line : *section) all += fmt::format("{}\n", line);
    return all + new_directory_ + new_parameters_ +
           fmt::format("S{:7}G{:7}D{:7}P{:7}{:40}T{:7}\n", start_.size(), global_.size(), directory_.size(), count_, "",
                       1);
  }

 private:
  static std::string_view trimmed_end(std::string_view line) { return line.substr(0, line.find_last_not_of("\r") + 1); }

  /// False where the directory does not fit the parameters.
  bool add_entity(std::string_view first, std::string_view second) {
    const auto begin = field(first, 1), lines = field(second, 3);
    if (!begin || !lines || *begin == 0 || *lines == 0 || *begin + *lines > parameters_.size() + 1) return false;
    const std::span<const std::string_view> old(&parameters_[*begin - 1], *lines);
    std::string text;
    for (const std::string_view line : old) text += line.substr(0, kParameters);
    Parameters all = parameters_of(text, by_);
    const auto spline = spline_of(all.texts);
    // Open CASCADE would crash at it.
    if (spline && spline->ranges > all.texts.size()) return leave_out(first, second, old[0]);
    const bool comment = text.find_first_not_of(' ', all.end) != text.npos,
               ranges = spline && complete_ranges(all.texts, *spline), strings = decode_strings(all.texts);
    const std::size_t before = count_;
    if (all.whole && (comment || ranges || strings)) {
      changed_ = true;
      add_parameters(all.texts, old[0].substr(kParameters, kField));
    } else {
      for (const std::string_view line : old) add_line(line.substr(0, kParameters), line.substr(kParameters, kField));
    }
    add_directory(first.substr(0, kField), first, second, count_ - before);
    return true;
  }

  /// Keeps the place of an entity in the directory, as that of a null entity.
  bool leave_out(std::string_view first, std::string_view second, std::string_view line) {
    job_.warn(0, fmt::format("entity D{} (type {}) has too few parameters and is not read",
                             trimmed(first.substr(kLetter + 1)), trimmed(first.substr(0, kField))));
    changed_ = true;
    add_line(std::string("0") + by_.record, line.substr(kParameters, kField));
    add_directory("       0", first, second, 1);
    return true;
  }

  /// The two lines of an entity whose last `lines` of parameters are its own.
  void add_directory(std::string_view type, std::string_view first, std::string_view second, std::size_t lines) {
    new_directory_ += fmt::format("{}{:8}{}\n{}{}{:8}{}\n", type, count_ - lines + 1, first.substr(2 * kField), type,
                                  second.substr(kField, 2 * kField), lines, second.substr(4 * kField));
  }

  void add_line(std::string_view text, std::string_view pointer) {
    new_parameters_ += fmt::format("{:<64}{}P{:7}\n", text, pointer, ++count_);
  }

  /// Numbers may not be divided between two lines. Strings may, at the last column.
  void add_parameters(const std::vector<std::string>& texts, std::string_view pointer) {
    std::string line;
    for (std::size_t i = 0; i < texts.size(); ++i) {
      const std::string next = texts[i] + (i + 1 == texts.size() ? by_.record : by_.parameter);
      if (line.size() + next.size() > kParameters) {
        add_line(line, pointer);
        line.clear();
      }
      line += next;
      for (; line.size() > kParameters; line.erase(0, kParameters)) add_line(line.substr(0, kParameters), pointer);
    }
    add_line(line, pointer);
  }

  bool decode_strings(std::vector<std::string>& texts) {
    bool changed = false;
    for (std::string& text : texts) {
      if (is_utf8(text)) continue;
      const auto string = string_at(text, 0);
      if (!string) continue;
      const std::string decoded = names_.decode(std::string_view(text).substr(text.find('H') + 1), 0);
      text = fmt::format("{}H{}", decoded.size(), decoded);
      changed = true;
    }
    return changed;
  }

  ImportJob& job_;
  Lines start_, global_, directory_, parameters_;
  NameDecoder names_;
  Delimiters by_;
  std::string new_directory_, new_parameters_;
  std::size_t count_ = 0;  // of new lines of parameters
  bool changed_ = false;
};

}  // namespace

std::optional<std::string> repaired_iges(ImportJob& job, std::string_view text) {
  return IgesRepair(job, text).run();
}

}  // namespace sightline::importers
