// The chunks of an RVM file and the layout of their bodies, shared by reader and writer. All numbers are big-endian.
//
// A chunk begins with 24 bytes: its tag, one ASCII character in the low byte of each of four words; the absolute offset
// of the next chunk; a word that is 1. Strings are a count of 4-byte words and that many words of NUL-padded text.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "sightline/core/mesh.h"
#include "sightline/core/primitive.h"

namespace sightline::importers::rvm {

inline constexpr std::uint64_t kHeaderBytes = 24;
inline constexpr std::uint64_t kFileAlignment = 1760;  ///< files are zero-padded to a multiple of this
inline constexpr std::uint32_t kFacetGroupKind = 11;
inline constexpr std::uint32_t kMaxTransparency = 100;

/// Keys of attributes for data that the scene has no place for. On a file's node: the strings of HEAD and MODL, where
/// not empty. On a group: its reference point in millimetres, "x y z", where not zero.
inline constexpr std::string_view kInfoKey = "rvm.info", kNoteKey = "rvm.note", kDateKey = "rvm.date",
                                  kUserKey = "rvm.user", kEncodingKey = "rvm.encoding", kProjectKey = "rvm.project",
                                  kModelKey = "rvm.model", kPositionKey = "rvm.position";

/// Reads forward within [position, limit) and never beyond. The first read that does not fit, or the first refused
/// value, makes the cursor fail for good: later reads yield zeros, and error() says where and what.
class ByteCursor {
 public:
  ByteCursor(std::span<const std::byte> file, std::uint64_t position, std::uint64_t limit)
      : file_(file), position_(position), limit_(limit) {}

  std::uint64_t position() const { return position_; }
  std::uint64_t remaining() const { return limit_ - position_; }
  bool ok() const { return error_.empty(); }
  const std::string& error() const { return error_; }
  std::uint64_t error_offset() const { return error_offset_; }

  bool require(std::uint64_t bytes, const char* what);
  std::uint32_t u32(const char* what) {
    if (!require(4, what)) return 0;
    const std::uint32_t value = peek_u32(position_);
    position_ += 4;
    return value;
  }
  float f32(const char* what) { return std::bit_cast<float>(u32(what)); }
  /// A count of things that take at least `bytes_each` (> 0) bytes; refused when the chunk cannot hold that many.
  std::uint32_t count(std::uint64_t bytes_each, const char* what);
  std::string_view string(const char* what);  ///< text before the first NUL; points into the file
  void skip(std::uint64_t bytes, const char* what) {
    if (require(bytes, what)) position_ += bytes;
  }
  void refuse(std::uint64_t offset, std::string message);

 private:
  std::uint32_t peek_u32(std::uint64_t at) const {
    const auto byte = [&](std::uint64_t i) { return std::to_integer<std::uint32_t>(file_[i]); };
    return byte(at) << 24 | byte(at + 1) << 16 | byte(at + 2) << 8 | byte(at + 3);
  }
  std::span<const std::byte> file_;
  std::uint64_t position_, limit_;
  std::uint64_t error_offset_ = 0;
  std::string error_;
};

struct ChunkHeader {
  std::array<char, 4> tag{};
  std::uint64_t offset = 0;  ///< where the header begins
  std::uint32_t next = 0;    ///< as stored
  std::string_view name() const { return {tag.data(), tag.size()}; }
};

/// Nothing when fewer than 24 bytes are left or the tag is not four printable characters.
std::optional<ChunkHeader> read_header(std::span<const std::byte> file, std::uint64_t offset);
bool is_known_tag(std::string_view tag);

struct Head {
  std::string_view info, note, date, user, encoding;
};
struct Model {
  std::string_view project, name;
};
struct Group {
  std::string_view name;
  std::array<float, 3> position{};  ///< millimetres, any bits
  std::uint32_t colour = 0, transparency = 0;
};
struct Colour {
  std::uint32_t index = 0;
  std::array<std::uint8_t, 3> rgb{};
};

/// PRIM, OBST or INSU, except for the polygons of a facet group.
struct Item {
  core::Kind kind{};
  std::array<float, 12> matrix{};     ///< three basis columns, translation; metres from local units
  std::array<float, 9> parameters{};  ///< of a primitive kind
  std::uint32_t transparency = 0;     ///< OBST, INSU: 0 to 100
  std::uint64_t facets = 0;           ///< offset of a facet group's polygons
  std::uint64_t facet_vertices = 0, facet_contours = 0, facet_polygons = 0;  ///< as stored
  std::uint64_t bad_polygons = 0, bad_normals = 0;  ///< of these polygons dropped; normals left out
  bool ambiguous =
      false;           ///< OBST, INSU: neither layout agreed with the stored box; taken as box, extra word, parameters
  bool finite = true;  ///< no number is NaN or infinite, but for those of bad polygons and normals
  double reach = 0.0;  ///< metres: no point of the item lies farther from the origin than this, give or take its
                       ///< shear, nor is an entry of its matrix larger
};

Head read_head(ByteCursor& cursor);
Model read_model(ByteCursor& cursor);
Group read_group(ByteCursor& cursor);
Colour read_colour(ByteCursor& cursor);
/// `extra_word`: whether the chunk has the four extra bytes of OBST and INSU.
Item read_item(ByteCursor& cursor, std::span<const std::byte> file, bool extra_word);
/// The triangulated polygons of an item that read_item accepted. Allocates what the counts say and no more.
core::Mesh read_facets(std::span<const std::byte> file, const Item& item);

}  // namespace sightline::importers::rvm
