// Internal to the importers: text of files as UTF-8. What leaves a reader (names, attributes, messages) is valid UTF-8,
// whatever the file holds.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace sightline::importers {

class ImportJob;

/// Bytes of the valid character that a text which is not empty begins with; 0 if it begins with none.
std::size_t utf8_length(std::string_view text);

bool is_utf8(std::string_view text);

/// Every byte is a character. The five that the code page leaves open become control characters, as on the web.
std::string utf8_from_windows_1252(std::string_view text);

/// Text of an encoding that nothing states: UTF-8 where it is valid, else Windows-1252.
std::string utf8_by_guess(std::string_view text);

/// The text of a file in UTF-16, which its byte order mark tells. Nothing for other files. Lone surrogates become
/// U+FFFD.
std::optional<std::string> utf8_from_utf16(std::span<const std::byte> file);

/// A file as its reader expects it: text in UTF-16 as UTF-8, which `decoded` then holds, with a warning.
std::span<const std::byte> without_utf16(ImportJob& job, std::span<const std::byte> file, std::string& decoded);

/// A whole text as UTF-8: as it is, or decoded from Windows-1252 into `decoded`, with a warning that names it as
/// `what`.
std::string_view as_utf8(ImportJob& job, std::string_view text, std::string_view what, std::string& decoded);

/// The begin of a file's text for a message: on one line, decoded, in quotes.
std::string excerpt(std::string_view text);

/// Text of an encoding by its name, as the system knows it; nothing where it does not, or where the text is not of it.
std::optional<std::string> utf8_from(std::string_view text, std::string_view encoding);

/// Decodes the names of a file: those that are UTF-8 as they are, others from what the file states. Else by guess, with
/// a warning at the first.
class NameDecoder {
 public:
  explicit NameDecoder(ImportJob& job) : job_(job) {}
  void state(std::string_view encoding) { stated_ = encoding; }
  /// `offset`, `line`: where the name stands; line 0: in a file that has none.
  std::string decode(std::string_view name, std::uint64_t offset, std::uint64_t line = 0);
  /// Whether any name was not UTF-8.
  bool has_decoded() const { return decoded_; }

 private:
  ImportJob& job_;
  std::string stated_;
  bool warned_ = false, decoded_ = false;
};

}  // namespace sightline::importers
