#include "sightline/importers/internal/json_text.h"

#include <algorithm>

namespace sightline::importers {
namespace {

std::string at_byte(std::string_view text, std::size_t byte) {
  const std::string_view before = text.substr(0, std::min(byte, text.size()));
  const auto line = 1 + std::count(before.begin(), before.end(), '\n');
  const std::size_t start = before.rfind('\n');
  const std::size_t column = before.size() - (start == std::string_view::npos ? 0 : start + 1) + 1;
  return "line " + std::to_string(line) + ", column " + std::to_string(column);
}

}  // namespace

core::Expected<Json> parse_json(std::string_view text, std::string_view source, int max_depth) {
  auto parsed = json::parse(text, {.sort = true, .max_depth = max_depth});
  if (parsed) return std::move(*parsed);
  const json::ParseError& error = parsed.error();
  const std::string where = std::string(source) + ": ";
  switch (error.kind) {
    case json::ParseError::Kind::kDepth:
      return core::fail(where + at_byte(text, error.byte) + ": " + error.reason);
    case json::ParseError::Kind::kRange:
      return core::fail(where + "expected JSON with numbers in the range of a double: " + error.reason);
    default:
      return core::fail(where + at_byte(text, error.byte) + ": expected JSON: " + error.reason);
  }
}

std::string describe(const Json& value) {
  if (value.is_array()) return "an array of " + std::to_string(value.size());
  if (value.is_number()) return "the number " + value.dump();
  if (value.is_object()) return "an object";
  if (value.is_string()) return "a string";
  return value.dump();
}

}  // namespace sightline::importers
