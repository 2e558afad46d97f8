// Internal to the PLY reader: parses a file's header.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/importers/import.h"
#include "sightline/importers/internal/byte_order.h"

namespace sightline::importers::ply {

enum class Encoding : std::uint8_t { kAscii, kLittleEndian, kBigEndian };
using Scalar = NumberType;

/// A property of an element. Names are views into the file.
struct Property {
  std::string_view name;
  Scalar type = Scalar::kFloat;
  std::optional<Scalar> count;  ///< of lists: the type of their length
};

struct Element {
  std::string_view name;
  std::uint64_t count = 0;  ///< as claimed
  std::vector<Property> properties;

  /// Bytes of the shortest record in a binary file; exact without lists.
  std::size_t least_bytes() const;
  bool has_lists() const;
};

struct Header {
  Encoding encoding = Encoding::kAscii;
  std::vector<Element> elements;
  std::size_t size = 0;               ///< bytes; the data begin there
  std::vector<std::string> warnings;  ///< what bends the specification: "line N: …"
  std::optional<UpAxis> up;           ///< that a comment names
  bool skipped_lines = false;         ///< some were not understood
};

/// Lines may end in LF, CR LF or CR, as the first one does. Errors read "line N: expected …, found …".
/// Keywords and types come in any case. Lines without a keyword are skipped, unless they look like a misspelt one.
core::Expected<Header> parse_header(std::span<const std::byte> file);

}  // namespace sightline::importers::ply
