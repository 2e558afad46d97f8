#include "sightline/apps/common/markup.h"

#include <utility>

#include "sightline/importers/internal/text_encoding.h"

namespace sightline::apps {
namespace {

/// Bytes of the character at the begin of `text`; 0 when it is none that XML allows (XML 1.0, section 2.2).
std::size_t character_length(std::string_view text) {
  const char c = text.front();
  if (static_cast<unsigned char>(c) < ' ' && c != '\t' && c != '\n' && c != '\r') return 0;
  if (text.starts_with("\xef\xbf\xbe") || text.starts_with("\xef\xbf\xbf")) return 0;  // U+FFFE, U+FFFF
  return importers::utf8_length(text);
}

}  // namespace

std::string escaped(std::string_view text) {
  constexpr std::pair<std::string_view, std::string_view> kReferences[] = {
      {"<", "&lt;"}, {">", "&gt;"}, {"&", "&amp;"}, {"\"", "&quot;"}, {"'", "&#39;"}};
  std::string out;
  while (!text.empty()) {
    const std::size_t length = character_length(text);
    std::string_view written = length == 0 ? "\xef\xbf\xbd" : text.substr(0, length);
    for (const auto& [character, reference] : kReferences)
      if (character == written) written = reference;
    out += written;
    text.remove_prefix(length == 0 ? 1 : length);
  }
  return out;
}

std::string csv_field(const std::string& text, char separator) {
  if (text.find_first_of(std::string("\"\r\n") + separator) == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted.append(c == '"' ? "\"\"" : std::string(1, c));
  return quoted + '"';
}

}  // namespace sightline::apps
