#include "sightline/importers/internal/text_encoding.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "sightline/core/internal/platform/encoding.h"
#include "sightline/importers/internal/import_job.h"

namespace sightline::importers {
namespace {

/// Code points of the bytes 0x80 … 0x9f. The rest of the code page is Latin-1.
constexpr std::array<char16_t, 32> kWindows1252 = {0x20ac, 0x0081, 0x201a, 0x0192, 0x201e, 0x2026, 0x2020, 0x2021,
                                                   0x02c6, 0x2030, 0x0160, 0x2039, 0x0152, 0x008d, 0x017d, 0x008f,
                                                   0x0090, 0x2018, 0x2019, 0x201c, 0x201d, 0x2022, 0x2013, 0x2014,
                                                   0x02dc, 0x2122, 0x0161, 0x203a, 0x0153, 0x009d, 0x017e, 0x0178};

void append_utf8(std::string& to, char32_t c) {
  const auto tail = [&](int shift) { to += char(0x80 | (c >> shift & 0x3f)); };
  if (c < 0x80) {
    to += char(c);
  } else if (c < 0x800) {
    to += char(0xc0 | c >> 6), tail(0);
  } else if (c < 0x10000) {
    to += char(0xe0 | c >> 12), tail(6), tail(0);
  } else {
    to += char(0xf0 | c >> 18), tail(12), tail(6), tail(0);
  }
}

}  // namespace

std::size_t utf8_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned first = byte(0);
  if (first < 0x80) return 1;
  const std::size_t length = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
  if (first < 0xc2 || first > 0xf4 || text.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i)
    if ((byte(i) & 0xc0) != 0x80) return 0;
  // Three bytes for what needs two, surrogates, four bytes for what needs three, and what lies beyond Unicode.
  const unsigned second = byte(1);
  if ((first == 0xe0 && second < 0xa0) || (first == 0xed && second >= 0xa0)) return 0;
  if ((first == 0xf0 && second < 0x90) || (first == 0xf4 && second >= 0x90)) return 0;
  return length;
}

bool is_utf8(std::string_view text) {
  while (!text.empty()) {
    const std::size_t length = utf8_length(text);
    if (length == 0) return false;
    text.remove_prefix(length);
  }
  return true;
}

std::string utf8_from_windows_1252(std::string_view text) {
  std::string decoded;
  decoded.reserve(text.size());
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    append_utf8(decoded, byte >= 0x80 && byte < 0xa0 ? kWindows1252[byte - 0x80] : byte);
  }
  return decoded;
}

std::string utf8_by_guess(std::string_view text) {
  return is_utf8(text) ? std::string(text) : utf8_from_windows_1252(text);
}

std::optional<std::string> utf8_from_utf16(std::span<const std::byte> file) {
  if (file.size() < 2) return {};
  const auto unit = [&](std::size_t at, bool big) {
    const auto first = std::to_integer<char32_t>(file[at]), second = std::to_integer<char32_t>(file[at + 1]);
    return big ? first << 8 | second : second << 8 | first;
  };
  constexpr char32_t kMark = 0xfeff, kReplacement = 0xfffd;
  const bool big = unit(0, true) == kMark;
  if (!big && unit(0, false) != kMark) return {};
  std::string text;
  text.reserve(file.size() / 2);
  for (std::size_t at = 2; at + 1 < file.size(); at += 2) {
    char32_t c = unit(at, big);
    if (c >= 0xd800 && c < 0xe000) {
      const char32_t low = c < 0xdc00 && at + 3 < file.size() ? unit(at + 2, big) : 0;
      const bool pair = low >= 0xdc00 && low < 0xe000;
      c = pair ? 0x10000 + ((c - 0xd800) << 10) + (low - 0xdc00) : kReplacement;
      if (pair) at += 2;
    }
    append_utf8(text, c);
  }
  return text;
}

std::span<const std::byte> without_utf16(ImportJob& job, std::span<const std::byte> file, std::string& decoded) {
  auto text = utf8_from_utf16(file);
  if (!text) return file;
  job.warn(0, "the file is UTF-16");
  decoded = std::move(*text);
  return std::as_bytes(std::span(decoded));
}

std::string_view as_utf8(ImportJob& job, std::string_view text, std::string_view what, std::string& decoded) {
  if (is_utf8(text)) return text;
  job.warn(0, fmt::format("{} is not UTF-8: taken for Windows-1252", what));
  decoded = utf8_from_windows_1252(text);
  return decoded;
}

std::string excerpt(std::string_view text) {
  constexpr std::size_t kMost = 40;
  std::string shown = utf8_by_guess(text);
  if (shown.size() > kMost) {
    std::size_t end = kMost;
    while (end > 0 && (static_cast<unsigned char>(shown[end]) & 0xc0) == 0x80) --end;  // no half character
    shown.resize(end);
    shown += "…";
  }
  std::replace_if(
      shown.begin(), shown.end(), [](char c) { return static_cast<unsigned char>(c) < ' ' || c == 127; }, ' ');
  return "'" + shown + "'";
}

std::optional<std::string> utf8_from(std::string_view text, std::string_view encoding) {
  auto decoded = core::platform::decoded(text, encoding);
  return decoded && is_utf8(*decoded) ? std::move(decoded) : std::nullopt;
}

std::string NameDecoder::decode(std::string_view name, std::uint64_t offset, std::uint64_t line) {
  if (is_utf8(name)) return std::string(name);
  decoded_ = true;
  if (!stated_.empty())
    if (auto as_stated = utf8_from(name, stated_)) return *as_stated;
  std::string decoded = utf8_from_windows_1252(name);
  const std::string where = line > 0 ? fmt::format("line {}: ", line) : "";
  if (!warned_)
    job_.warn(offset,
              fmt::format("{}names are not UTF-8: taken for Windows-1252, the first as {}", where, excerpt(decoded)));
  warned_ = true;
  return decoded;
}

}  // namespace sightline::importers
