#include "sightline/importers/internal/json_text.h"

#include <algorithm>
#include <optional>

namespace sightline::importers {
namespace {

std::string at_byte(std::string_view text, std::size_t byte) {
  const std::string_view before = text.substr(0, std::min(byte, text.size()));
  const auto line = 1 + std::count(before.begin(), before.end(), '\n');
  const std::size_t start = before.rfind('\n');
  const std::size_t column = before.size() - (start == std::string_view::npos ? 0 : start + 1) + 1;
  return "line " + std::to_string(line) + ", column " + std::to_string(column);
}

/// Where the text first nests deeper than max_depth. The parser's own stack is safe at any depth; the values that it
/// builds are not.
std::optional<std::size_t> too_deep(std::string_view text, int max_depth) {
  int depth = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      if (c == '\\') ++i;
      if (c == '"') in_string = false;
    } else if (c == '"') {
      in_string = true;
    } else if (c == '[' || c == '{') {
      if (++depth > max_depth) return i;
    } else if (c == ']' || c == '}') {
      --depth;
    }
  }
  return std::nullopt;
}

/// The message without nlohmann's prefix: "[json.exception.parse_error.101] parse error at line 1, column 2: " …
std::string reason(const std::string& what) {
  const std::size_t column = what.find("column ");
  const std::size_t colon = column == std::string::npos ? what.find("] ") : what.find(": ", column);
  return colon == std::string::npos ? what : what.substr(colon + 2);
}

}  // namespace

core::Expected<Json> parse_json(std::string_view text, std::string_view source, int max_depth) {
  const std::string where = std::string(source) + ": ";
  if (const auto byte = too_deep(text, max_depth))
    return core::fail(where + at_byte(text, *byte) + ": expected at most " + std::to_string(max_depth) +
                      " nested arrays and objects");
  try {
    return Json::parse(text.begin(), text.end());
  } catch (const Json::parse_error& e) {
    const std::size_t byte = e.byte > 0 ? e.byte - 1 : 0;
    return core::fail(where + at_byte(text, byte) + ": expected JSON: " + reason(e.what()));
  } catch (const Json::exception& e) {
    return core::fail(where + "expected JSON with numbers in the range of a double: " + reason(e.what()));
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
