#include <algorithm>
#include <charconv>
#include <string>

#include "sightline/importers/internal/side_files.h"
#include "sightline/importers/internal/text_encoding.h"

namespace sightline::importers {
namespace {

std::string with_slashes(std::string_view name) {
  std::string changed(name);
  std::replace(changed.begin(), changed.end(), '\\', '/');
  return changed;
}

}  // namespace

std::string percent_decoded(std::string_view uri) {
  std::string decoded;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    unsigned value = 0;
    const char* const digits = uri.data() + i + 1;
    if (uri[i] == '%' && i + 2 < uri.size() && std::from_chars(digits, digits + 2, value, 16).ptr == digits + 2) {
      decoded += char(value);
      i += 2;
    } else {
      decoded += uri[i];
    }
  }
  return decoded;
}

core::Expected<std::filesystem::path> find_named_file(const std::filesystem::path& model, std::string_view name) {
  auto as_written = find_side_file(model, name);
  if (as_written) return as_written;
  const std::string slashes = with_slashes(name), decoded = percent_decoded(slashes);
  std::string former(name);
  for (const std::string& other : {slashes, decoded, utf8_by_guess(slashes), utf8_by_guess(decoded)}) {
    if (other == former) continue;
    if (auto found = find_side_file(model, other)) return found;
    former = other;
  }
  return as_written;
}

}  // namespace sightline::importers
