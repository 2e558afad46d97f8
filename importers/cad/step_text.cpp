#include "sightline/importers/cad/internal/step_text.h"

#include <algorithm>
#include <charconv>
#include <iterator>

namespace sightline::importers {
namespace {

constexpr std::size_t kNowhere = std::string_view::npos;

constexpr bool is_digit(char c) {
  return c >= '0' && c <= '9';
}
constexpr bool is_keyword(char c) {
  return is_digit(c) || c == '_' || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '!';
}

/// Past a string or a binary that begins here, or past one character. The end where it does not end.
std::size_t past_token(std::string_view text, std::size_t at) {
  if (text[at] != '\'' && text[at] != '"') return at + 1;
  const std::size_t end = text.find(text[at], at + 1);  // a doubled quote looks like the next string
  return end == kNowhere ? text.size() : end + 1;
}

std::size_t past_blank(std::string_view text, std::size_t at) {
  while (at < text.size() && static_cast<unsigned char>(text[at]) <= ' ') ++at;
  return at;
}

/// Past the bracket that closes the one at `at`.
std::size_t past_group(std::string_view text, std::size_t at) {
  std::size_t depth = 0;
  while (at < text.size()) {
    if (text[at] == '(') ++depth;
    if (text[at] == ')' && --depth == 0) return at + 1;
    at = past_token(text, at);
  }
  return kNowhere;
}

/// The number of "#12" at `at`, which moves behind it.
std::optional<std::uint64_t> reference_at(std::string_view text, std::size_t& at) {
  if (at >= text.size() || text[at] != '#') return std::nullopt;
  std::uint64_t id = 0;
  const auto [end, failed] = std::from_chars(text.data() + at + 1, text.data() + text.size(), id);
  if (failed != std::errc()) return std::nullopt;
  at = std::size_t(end - text.data());
  return id;
}

/// "KEYWORD(...)" at `at`, which moves behind it.
std::optional<StepRecord> record_at(std::string_view text, std::size_t& at) {
  const std::size_t begin = at = past_blank(text, at);
  while (at < text.size() && is_keyword(text[at])) ++at;
  StepRecord record{text.substr(begin, at - begin), {}};
  const std::size_t open = past_blank(text, at);
  if (record.keyword.empty() || open >= text.size() || text[open] != '(') return std::nullopt;
  const std::size_t end = past_group(text, open);
  if (end == kNowhere) return std::nullopt;
  at = end;
  record.parameters = step_list(text.substr(open, end - open));
  return record;
}

}  // namespace

StepText::StepText(std::string_view text) {
  std::size_t begin = 0;
  for (std::size_t at = 0; at < text.size(); at = past_token(text, at)) {
    if (text[at] != ';') continue;
    std::size_t from = past_blank(text, begin);
    begin = at + 1;
    const auto id = reference_at(text, from);
    from = past_blank(text, from);
    if (id && from < at && text[from] == '=') entities_.push_back({*id, text.substr(from + 1, at - from - 1)});
  }
  const auto before = [](const Entity& a, const Entity& b) { return a.id < b.id; };
  const auto same = [](const Entity& a, const Entity& b) { return a.id == b.id; };
  if (!std::is_sorted(entities_.begin(), entities_.end(), before))
    std::stable_sort(entities_.begin(), entities_.end(), before);
  entities_.erase(std::unique(entities_.begin(), entities_.end(), same), entities_.end());
}

const StepText::Entity* StepText::find(std::uint64_t id) const {
  const auto at = std::lower_bound(entities_.begin(), entities_.end(), id,
                                   [](const Entity& entity, std::uint64_t wanted) { return entity.id < wanted; });
  return at != entities_.end() && at->id == id ? &*at : nullptr;
}

std::vector<StepRecord> StepText::records(std::uint64_t id) const {
  const Entity* entity = find(id);
  return entity ? step_records(entity->text) : std::vector<StepRecord>();
}

std::vector<StepRecord> step_records(std::string_view entity) {
  std::vector<StepRecord> found;
  std::size_t at = past_blank(entity, 0);
  const bool complex = at < entity.size() && entity[at] == '(';
  if (complex) ++at;
  while (auto record = record_at(entity, at)) {
    found.push_back(std::move(*record));
    if (!complex) break;
  }
  return found;
}

const StepRecord* find_record(const std::vector<StepRecord>& records, std::string_view keyword) {
  const auto at = std::find_if(records.begin(), records.end(), [&](const auto& r) { return r.keyword == keyword; });
  return at == records.end() ? nullptr : &*at;
}

std::vector<std::string_view> step_list(std::string_view parameter) {
  std::vector<std::string_view> elements;
  std::size_t at = past_blank(parameter, 0);
  if (at >= parameter.size() || parameter[at] != '(') return elements;
  std::size_t begin = at = past_blank(parameter, at + 1);
  if (at < parameter.size() && parameter[at] == ')') return elements;
  while (at < parameter.size()) {
    const char c = parameter[at];
    if (c == ',' || c == ')') elements.push_back(parameter.substr(begin, at - begin));
    if (c == ')') break;
    if (c == '(') {
      at = past_group(parameter, at);
    } else {
      at = past_token(parameter, at);
      if (c == ',') begin = at = past_blank(parameter, at);
    }
  }
  return elements;
}

std::vector<double> step_numbers(std::string_view parameter) {
  std::vector<double> numbers;
  for (std::size_t at = 0; at < parameter.size();) {
    const char c = parameter[at];
    double value = 0.0;
    if (is_digit(c) || c == '-' || c == '.') {
      const auto [end, failed] = std::from_chars(parameter.data() + at, parameter.data() + parameter.size(), value);
      if (failed == std::errc()) {
        numbers.push_back(value);
        at = std::size_t(end - parameter.data());
        continue;
      }
    }
    at = past_token(parameter, at);
  }
  return numbers;
}

std::optional<std::uint64_t> step_reference(std::string_view parameter) {
  std::size_t at = past_blank(parameter, 0);
  return reference_at(parameter, at);
}

}  // namespace sightline::importers
