#include "sightline/importers/ply/internal/ply_header.h"

#include <algorithm>
#include <charconv>

#include <fmt/format.h>

namespace sightline::importers::ply {
namespace {

struct NamedScalar {
  std::string_view name;
  Scalar type;
};
constexpr NamedScalar kScalars[] = {
    {"char", Scalar::kInt8},     {"int8", Scalar::kInt8},     {"uchar", Scalar::kUint8},
    {"uint8", Scalar::kUint8},   {"short", Scalar::kInt16},   {"int16", Scalar::kInt16},
    {"int", Scalar::kInt32},     {"int32", Scalar::kInt32},   {"ushort", Scalar::kUint16},
    {"uint16", Scalar::kUint16}, {"uint", Scalar::kUint32},   {"uint32", Scalar::kUint32},
    {"float", Scalar::kFloat},   {"float32", Scalar::kFloat}, {"double", Scalar::kDouble},
    {"float64", Scalar::kDouble}};

std::optional<Scalar> scalar_named(std::string_view name) {
  for (const NamedScalar& known : kScalars)
    if (known.name == name) return known.type;
  return {};
}

/// Makes a name safe for a message: names come from the file, which may hold anything.
std::string shown(std::string_view text) {
  std::string out(text.substr(0, 40));
  for (char& c : out)
    if (c < ' ' || c > '~') c = '?';
  return "'" + out + "'";
}

class HeaderParser {
 public:
  explicit HeaderParser(std::span<const std::byte> file)
      : text_(reinterpret_cast<const char*>(file.data()), file.size()) {}

  core::Expected<Header> run() {
    if (!begins_as_ply()) return core::fail("not a PLY file: expected a first line 'ply'");
    if (auto done = format_line(); !done) return tl::unexpected(done.error());
    for (;;) {
      if (!next_line()) return expected("end_header", "the file's end");
      const std::string_view keyword = word();
      if (keyword == "end_header") break;
      if (keyword == "comment" || keyword == "obj_info" || keyword.empty()) continue;
      auto done = keyword == "element"    ? element_line()
                  : keyword == "property" ? property_line()
                                          : expected("comment, element, property or end_header", shown(keyword));
      if (!done) return tl::unexpected(done.error());
    }
    header_.size = at_;
    return std::move(header_);
  }

 private:
  bool begins_as_ply() {
    const std::size_t end = text_.find_first_of("\r\n");
    if (end != 3 || text_.substr(0, 3) != "ply") return false;
    if (text_[end] == '\r' && text_.substr(end, 2) != "\r\n") line_end_ = '\r';
    at_ = text_.find(line_end_) + 1;
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

  core::Expected<void> format_line() {
    do {
      if (!next_line()) return expected("a format line", "the file's end");
    } while (rest_.starts_with("comment") || rest_.starts_with("obj_info"));
    if (word() != "format") return expected("'format'", shown(rest_));
    const std::string_view name = word(), version = word();
    if (name == "ascii")
      header_.encoding = Encoding::kAscii;
    else if (name == "binary_little_endian")
      header_.encoding = Encoding::kLittleEndian;
    else if (name == "binary_big_endian")
      header_.encoding = Encoding::kBigEndian;
    else
      return expected("ascii, binary_little_endian or binary_big_endian", shown(name));
    if (version != "1.0") return expected("version 1.0", shown(version));
    return {};
  }

  core::Expected<void> element_line() {
    Element element;
    element.name = word();
    const std::string_view count = word();
    const auto [stop, error] = std::from_chars(count.data(), count.data() + count.size(), element.count);
    if (element.name.empty()) return expected("an element's name", "the line's end");
    if (error != std::errc() || stop != count.data() + count.size())
      return expected("how many elements there are", shown(count));
    header_.elements.push_back(std::move(element));
    return {};
  }

  core::Expected<void> property_line() {
    if (header_.elements.empty()) return expected("an element before its properties", "a property");
    Property property;
    std::string_view type = word();
    if (type == "list") {
      property.count = scalar_named(type = word());
      if (!property.count) return expected("the type of a list's length", shown(type));
      type = word();
    }
    const auto known = scalar_named(type);
    if (!known) return expected("a property's type", shown(type));
    property.type = *known;
    property.name = word();
    if (property.name.empty()) return expected("a property's name", "the line's end");
    header_.elements.back().properties.push_back(property);
    return {};
  }

  std::string_view text_, rest_;
  char line_end_ = '\n';  // CR LF too: the CR is space
  std::size_t at_ = 0;
  std::uint64_t line_ = 1;
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
