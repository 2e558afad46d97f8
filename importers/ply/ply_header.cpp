#include "sightline/importers/ply/internal/ply_header.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>

#include <fmt/format.h>

#include "sightline/core/internal/ascii_case.h"
#include "sightline/importers/internal/text_scanner.h"
#include "sightline/importers/internal/up_axis.h"

namespace sightline::importers::ply {
namespace {

struct NamedScalar {
  std::string_view name;
  Scalar type;
};
constexpr NamedScalar kScalars[] = {
    {"char", Scalar::kInt8},     {"int8", Scalar::kInt8},     {"uchar", Scalar::kUint8}, {"uint8", Scalar::kUint8},
    {"short", Scalar::kInt16},   {"int16", Scalar::kInt16},   {"int", Scalar::kInt32},   {"int32", Scalar::kInt32},
    {"ushort", Scalar::kUint16}, {"uint16", Scalar::kUint16}, {"uint", Scalar::kUint32}, {"uint32", Scalar::kUint32},
    {"int64", Scalar::kInt64},   {"uint64", Scalar::kUint64}, {"float", Scalar::kFloat}, {"float32", Scalar::kFloat},
    {"double", Scalar::kDouble}, {"float64", Scalar::kDouble}};

std::optional<Scalar> scalar_named(std::string_view name) {
  for (const NamedScalar& known : kScalars)
    if (core::same_but_for_case(known.name, name)) return known.type;
  return {};
}

/// Whether one or two letters are missing, too many or wrong (edit distance).
bool is_nearly(std::string_view word, std::string_view keyword) {
  constexpr std::size_t kMostWrong = 2, kLongest = 12;
  if (word.size() > kLongest || keyword.size() > kLongest) return false;
  std::array<std::size_t, kLongest + 1> row{};
  for (std::size_t j = 0; j <= keyword.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= word.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i);
    for (std::size_t j = 1; j <= keyword.size(); ++j) {
      const std::size_t changed =
          diagonal + (core::same_but_for_case(word.substr(i - 1, 1), keyword.substr(j - 1, 1)) ? 0 : 1);
      diagonal = std::exchange(row[j], std::min({changed, row[j] + 1, row[j - 1] + 1}));
    }
  }
  return row[keyword.size()] <= kMostWrong;
}

class HeaderParser {
 public:
  explicit HeaderParser(std::span<const std::byte> file)
      : text_(reinterpret_cast<const char*>(file.data()), file.size()) {}

  core::Expected<Header> run() {
    if (!begins_as_ply()) return core::fail("not a PLY file: expected a first line 'ply'");
    for (;;) {
      if (!next_line()) return expected(has_format_ ? "end_header" : "a format line", "the file's end");
      const std::string_view keyword = word();
      if (core::same_but_for_case(keyword, "end_header")) break;
      if (core::same_but_for_case(keyword, "comment") || core::same_but_for_case(keyword, "obj_info")) {
        if (const auto up = up_axis_in_comment(rest_)) header_.up = up;
        continue;
      }
      if (keyword.empty()) continue;
      if (auto done = line_of(keyword); !done) return tl::unexpected(done.error());
    }
    if (!has_format_) return expected("a format line before the header's end", "none");
    if (skipped_ > 0)
      warn(first_skipped_, skipped_ == 1 ? "a line without a keyword is skipped"
                                         : fmt::format("lines without a keyword are skipped ({} times)", skipped_));
    header_.skipped_lines = skipped_ > 0;
    header_.size = at_;
    return std::move(header_);
  }

 private:
  bool begins_as_ply() {
    const bool mark = text_.starts_with(kByteOrderMark);
    const std::size_t begin = mark ? kByteOrderMark.size() : 0, end = text_.find_first_of("\r\n");
    if (end == std::string_view::npos || !core::same_but_for_case(trimmed(text_.substr(begin, end - begin)), "ply"))
      return false;
    if (text_[end] == '\r' && text_.substr(end, 2) != "\r\n") line_end_ = '\r';
    at_ = text_.find(line_end_) + 1;
    if (mark) warn(line_, "a byte order mark is skipped");
    return true;
  }

  bool next_line() {
    const std::size_t end = text_.find(line_end_, at_);
    if (end == std::string_view::npos) return false;
    rest_ = text_.substr(at_, end - at_);
    at_ = end + 1;
    ++line_;
    return true;
  }

  std::string_view word() {
    constexpr std::string_view kSpace = " \t\r";
    rest_.remove_prefix(std::min(rest_.find_first_not_of(kSpace), rest_.size()));
    const std::string_view found = rest_.substr(0, rest_.find_first_of(kSpace));
    rest_.remove_prefix(found.size());
    return found;
  }

  tl::unexpected<core::Error> expected(std::string_view what, std::string_view found) const {
    return core::fail(fmt::format("line {}: expected {}, found {}", line_, what, found));
  }

  core::Expected<void> line_of(std::string_view keyword) {
    if (core::same_but_for_case(keyword, "format")) return format_line();
    if (core::same_but_for_case(keyword, "element")) return element_line();
    if (core::same_but_for_case(keyword, "property")) return property_line();
    for (const std::string_view known : {"element", "property", "end_header"})
      if (is_nearly(keyword, known)) return expected("comment, element, property or end_header", shown_word(keyword));
    if (skipped_++ == 0) first_skipped_ = line_;
    return {};
  }

  void warn(std::uint64_t line, std::string_view message) {
    header_.warnings.push_back(fmt::format("line {}: {}", line, message));
  }

  core::Expected<void> format_line() {
    has_format_ = true;
    const std::string_view name = word(), version = word();
    if (core::same_but_for_case(name, "ascii"))
      header_.encoding = Encoding::kAscii;
    else if (core::same_but_for_case(name, "binary_little_endian"))
      header_.encoding = Encoding::kLittleEndian;
    else if (core::same_but_for_case(name, "binary_big_endian"))
      header_.encoding = Encoding::kBigEndian;
    else
      return expected("ascii, binary_little_endian or binary_big_endian", shown_word(name));
    if (version != "1.0") return expected("version 1.0", shown_word(version));
    return {};
  }

  core::Expected<void> element_line() {
    Element element;
    element.name = word();
    const std::string_view count = word();
    const auto [stop, error] = std::from_chars(count.data(), count.data() + count.size(), element.count);
    if (element.name.empty()) return expected("an element's name", "the line's end");
    if (error != std::errc() || stop != count.data() + count.size())
      return expected("how many elements there are", shown_word(count));
    header_.elements.push_back(std::move(element));
    return {};
  }

  core::Expected<void> property_line() {
    if (header_.elements.empty()) return expected("an element before its properties", "a property");
    Property property;
    std::string_view type = word();
    if (core::same_but_for_case(type, "list")) {
      property.count = scalar_named(type = word());
      if (!property.count) return expected("the type of a list's length", shown_word(type));
      type = word();
    }
    const auto known = scalar_named(type);
    if (!known) return expected("a property's type", shown_word(type));
    property.type = *known;
    property.name = word();
    if (property.name.empty()) return expected("a property's name", "the line's end");
    header_.elements.back().properties.push_back(property);
    return {};
  }

  std::string_view text_, rest_;
  char line_end_ = '\n';  // CR LF too: the CR is space
  std::size_t at_ = 0;
  std::uint64_t line_ = 1, skipped_ = 0, first_skipped_ = 0;
  bool has_format_ = false;
  Header header_;
};

}  // namespace

std::size_t Element::least_bytes() const {
  std::size_t bytes = 0;
  for (const Property& p : properties) bytes += size_of(p.count.value_or(p.type));
  return bytes;
}

bool Element::has_lists() const {
  return std::any_of(properties.begin(), properties.end(), [](const Property& p) { return p.count.has_value(); });
}

core::Expected<Header> parse_header(std::span<const std::byte> file) {
  return HeaderParser(file).run();
}

}  // namespace sightline::importers::ply
