#include "sightline/importers/stl/internal/stl_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "sightline/importers/internal/byte_order.h"
#include "sightline/importers/internal/face_colours.h"
#include "sightline/importers/internal/import_job.h"
#include "sightline/importers/internal/text_encoding.h"
#include "sightline/importers/internal/text_scanner.h"
#include "sightline/importers/internal/vertex_welder.h"
#include "sightline/importers/stl/internal/stl_text.h"

namespace sightline::importers {
namespace {

using core::dvec3;

constexpr std::size_t kHeaderBytes = 84, kFacetBytes = 50;

template <class T>
T little(const std::byte* from) {
  return load<T, std::endian::little>(from);
}

std::size_t claimed_facets(std::span<const std::byte> bytes) {
  return little<std::uint32_t>(bytes.data() + kHeaderBytes - 4);
}

// --- which form ------------------------------------------------------------------------------------------------------

constexpr bool is_zero(std::byte b) {
  return b == std::byte{0};
}

std::span<const std::byte> without_zeros_at_the_end(std::span<const std::byte> bytes) {
  std::size_t size = bytes.size();
  while (size > 0 && is_zero(bytes[size - 1])) --size;
  return bytes.first(size);
}

/// Whether a first part has no byte that no text has.
bool is_printable(std::span<const std::byte> bytes) {
  constexpr std::size_t kLookedAt = 512;
  const auto begin = bytes.first(std::min(kLookedAt, bytes.size()));
  return std::none_of(begin.begin(), begin.end(), [](std::byte b) {
    const auto c = std::to_integer<unsigned char>(b);
    return (c < ' ' && !is_space(char(c)) && c != 0x1a && c != 0x1b) || c == 0x7f;
  });
}

/// Whether a line within a first part begins with a keyword.
bool has_line(std::span<const std::byte> bytes, std::initializer_list<std::string_view> keywords) {
  constexpr std::size_t kLookedAt = 65536;
  const std::size_t mark = begins_with_mark(bytes) ? kByteOrderMark.size() : 0;
  TextScanner scanner(bytes.subspan(mark, std::min(kLookedAt, bytes.size() - mark)));
  do {
    if (stl::is_one_of(scanner.word_in_line(), keywords)) return true;
    scanner.rest_of_line();
  } while (scanner.next_line());
  return false;
}

/// By what the file holds, as many writers of the binary form begin with "solid". Text may begin with comments, and
/// hold zeros within a name or at its end.
bool is_text(std::span<const std::byte> bytes) {
  if (is_printable(without_zeros_at_the_end(bytes))) return has_line(bytes, {"solid", "facet"});
  return has_line(bytes, {"facet"}) && has_line(bytes, {"vertex"});
}

/// Text in two bytes a letter without a byte order mark: no form of STL, but not a binary file either.
bool is_wide_text(std::span<const std::byte> bytes) {
  using namespace std::string_view_literals;
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return text.starts_with("s\0o\0l\0"sv) || text.starts_with("\0s\0o\0l"sv);
}

// --- binary
// ------------------------------------------------------------------------------------------------------------

/// Whether any facet has other attributes than 0.
bool has_attributes(std::span<const std::byte> bytes, std::size_t facets) {
  for (std::size_t i = 0; i < facets; ++i)
    if (little<std::uint16_t>(bytes.data() + kHeaderBytes + i * kFacetBytes + 48) != 0) return true;
  return false;
}

/// What attribute bytes mean in this file: colours of five bits a channel, in one of three ways.
class AttributeColours {
 public:
  AttributeColours(std::span<const std::byte> bytes, std::size_t facets) {
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), kHeaderBytes - 4);
    const std::size_t key = text.find("COLOR=");
    if (key == std::string_view::npos || key + 10 > text.size()) return;
    const auto byte = [&](std::size_t i) { return std::uint32_t(std::uint8_t(text[key + 6 + i])); };
    if (text.substr(key + 9).starts_with(" MATERIAL=")) {
      colour_mode_ = ColourMode::kMeshLab;
    } else {
      colour_mode_ = has_attributes(bytes, facets) ? ColourMode::kMagics : ColourMode::kDefault;
      default_ = pack_colour(byte(0), byte(1), byte(2), byte(3));
    }
  }
  PackedColour operator()(std::uint16_t attribute) const {
    const auto channel = [&](int shift) {
      const std::uint32_t five = attribute >> shift & 31u;
      return five << 3 | five >> 2;
    };
    const bool bit_15 = (attribute & 0x8000u) != 0;
    const PackedColour red_low = pack_colour(channel(0), channel(5), channel(10));
    switch (colour_mode_) {
      case ColourMode::kVisCam:
        return bit_15 ? pack_colour(channel(10), channel(5), channel(0)) : kNoColour;
      case ColourMode::kMagics:
        return bit_15 ? default_ : red_low;
      case ColourMode::kMeshLab:
        return bit_15 ? red_low : kNoColour;
      case ColourMode::kDefault:
        return default_;
    }
    return kNoColour;
  }

 private:
  enum class ColourMode : std::uint8_t {
    kVisCam,   ///< no colour in the header; bit 15 says that a facet has one, red in the high bits
    kMagics,   ///< COLOR=rgba in the header is that of facets with bit 15; others have their own, red in the low bits
    kMeshLab,  ///< COLOR=rgb MATERIAL=…, but bit 15 says that a facet has a colour, red in the low bits
    kDefault,  ///< as kMagics, but no facet has a colour of its own
  };
  ColourMode colour_mode_ = ColourMode::kVisCam;
  PackedColour default_ = kNoColour;
};

dvec3 vector_at(const std::byte* from) {
  return {little<float>(from), little<float>(from + 4), little<float>(from + 8)};
}

/// Whether a record may be a facet: its coordinates are zero or of a size that models have. Of random records one in
/// hundreds is.
bool may_be_facet(const std::byte* record) {
  for (std::size_t i = 3; i < 12; ++i) {
    const float size = std::abs(little<float>(record + 4 * i));
    if (size != 0.0f && !(size > 1e-20f && size < 1e20f)) return false;
  }
  return true;
}

/// Whether the record has the normal of a facet: of length one, along its triangle's, or none.
bool has_normal_of_facet(const std::byte* record) {
  const dvec3 normal = vector_at(record), first = vector_at(record + 12);
  const dvec3 across = glm::cross(vector_at(record + 24) - first, vector_at(record + 36) - first);
  const double square = glm::dot(normal, normal), along = glm::dot(normal, across);
  if (!(square > 0.0)) return true;  // NaN, too: of a triangle without area
  return std::abs(square - 1.0) < 0.02 || (along > 0.0 && along * along > 0.98 * square * glm::dot(across, across));
}

/// How many facets a binary file has. Writers that do not know the number beforehand leave it 0 or absurd, and some
/// append bytes of their own. So the length decides where the records beyond the count look like facets, and where
/// there are fewer records than counted; but a file that ends within a facet was cut off.
class FacetCount {
 public:
  FacetCount(ImportJob& job, std::span<const std::byte> bytes)
      : job_(job), bytes_(bytes), body_(bytes.size() - kHeaderBytes), claimed_(claimed_facets(bytes)) {}

  core::Expected<std::size_t> run() {
    const std::size_t whole = body_ / kFacetBytes;
    if (claimed_ > whole || claimed_ == 0) {
      const std::size_t likely = likely_facets(0, whole);
      if (whole > 0 && likely == whole && body_ % kFacetBytes == 0 && !is_fill(whole - 1)) {
        warn_of_count(whole);
        return whole;
      }
      if (2 * likely < whole)
        return core::fail(
            fmt::format("{}: not an STL file: expected facets, found {} bytes that are none", job_.file(), body_));
    }
    if (claimed_ > whole) {
      if (auto told = not_as_claimed(); !told) return tl::unexpected(told.error());
      return before_displaced(whole);
    }
    const std::size_t facets = with_uncounted(whole), rest = body_ - facets * kFacetBytes;
    if (facets == 0 && rest > 0)
      if (auto told = not_as_claimed(); !told) return tl::unexpected(told.error());
    if (facets > claimed_) warn_of_count(facets);
    if (rest > 0)
      job_.warn(bytes_.size() - rest,
                fmt::format("byte {}: {} bytes after the last facet are ignored", bytes_.size() - rest, rest));
    return facets;
  }

 private:
  const std::byte* record(std::size_t i) const { return bytes_.data() + kHeaderBytes + i * kFacetBytes; }

  bool is_fill(std::size_t i) const { return std::all_of(record(i), record(i + 1), is_zero); }

  std::size_t likely_facets(std::size_t first, std::size_t end) const {
    std::size_t likely = 0;
    for (std::size_t i = first; i < end; ++i) likely += may_be_facet(record(i)) ? 1 : 0;
    return likely;
  }

  /// Bytes that are missing within a file displace all records behind them, which are no facets then.
  std::size_t before_displaced(std::size_t whole) {
    constexpr std::size_t kLookedAt = 8;
    for (std::size_t i = 0; i < whole; ++i) {
      if (may_be_facet(record(i))) continue;
      const std::size_t end = std::min(whole, i + kLookedAt);
      if (2 * likely_facets(i, end) >= end - i) continue;
      const std::size_t at = kHeaderBytes + i * kFacetBytes;
      job_.warn(at, fmt::format("byte {}: what follows is no facets: {} records left out", at, whole - i));
      return i;
    }
    return whole;
  }

  /// The facets that the header counts, and those behind that it does not.
  std::size_t with_uncounted(std::size_t whole) const {
    while (whole > claimed_ && is_fill(whole - 1)) --whole;
    std::size_t facets = claimed_;
    while (facets < whole && may_be_facet(record(facets)) && has_normal_of_facet(record(facets))) ++facets;
    return facets;
  }

  core::Expected<void> not_as_claimed() {
    return job_.damage(kHeaderBytes - 4, fmt::format("byte {}: expected {} facets of {} bytes, found {} bytes",
                                                     kHeaderBytes - 4, claimed_, kFacetBytes, body_));
  }
  void warn_of_count(std::size_t facets) {
    job_.warn(kHeaderBytes - 4, fmt::format("byte {}: the header counts {} facets, the file holds {}: all are read",
                                            kHeaderBytes - 4, claimed_, facets));
  }

  ImportJob& job_;
  std::span<const std::byte> bytes_;
  std::size_t body_, claimed_;
};

core::Expected<void> read_binary(ImportJob& job, std::span<const std::byte> bytes) {
  const auto counted = FacetCount(job, bytes).run();
  if (!counted) return tl::unexpected(counted.error());
  const std::size_t facets = *counted;
  if (3 * facets >= core::kNone)
    return core::fail(fmt::format("{}: expected fewer than {} facets, found {}", job.file(), core::kNone / 3, facets));

  const AttributeColours colour_of(bytes, facets);
  VertexWelder welder(facets / 2);  // closed surfaces have half as many vertices as facets
  PolygonMesh mesh;
  mesh.corners.reserve(3 * facets);
  std::vector<PackedColour> colours;
  std::array<dvec3, VertexWelder::kBlock> block;
  for (std::size_t first = 0; first < facets;) {
    if (auto asked = job.progress(0.7 * double(first) / double(facets)); !asked) return asked;
    const std::size_t count = std::min(VertexWelder::kBlock / 3, facets - first);
    for (std::size_t f = 0; f < count; ++f) {
      const std::byte* const corners = bytes.data() + kHeaderBytes + (first + f) * kFacetBytes + 12;
      for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t k = 0; k < 3; ++k)
          block[3 * f + c][glm::length_t(k)] = double(little<float>(corners + 12 * c + 4 * k));
      const PackedColour colour = colour_of(little<std::uint16_t>(corners + 36));
      if (colours.empty() && colour == kNoColour) continue;
      colours.resize(first + f, kNoColour);
      colours.push_back(colour);
    }
    welder.add({block.data(), 3 * count}, mesh.corners);
    first += count;
  }
  if (facets == 0) {
    job.warn(0, "no facets");
    return {};
  }
  mesh.positions = welder.take_positions();
  if (colours.empty()) {
    job.add_mesh(job.file_node(), mesh, job.file(), {}, {});
  } else {
    colours.resize(facets, kNoColour);
    add_coloured_meshes(job, job.file_node(), mesh, colours, job.file());
  }
  return {};
}

core::Expected<void> read_either_form(ImportJob& job, std::span<const std::byte> bytes) {
  const bool exact =
      bytes.size() >= kHeaderBytes && bytes.size() - kHeaderBytes == kFacetBytes * std::size_t{claimed_facets(bytes)};
  if (!exact) {
    std::string decoded;
    const auto text = without_utf16(job, bytes, decoded);
    if (is_text(text)) return stl::read_text(job, text);
  }
  const bool other_text = !exact && (is_printable(bytes) || is_wide_text(bytes));
  if (!other_text && bytes.size() >= kHeaderBytes) return read_binary(job, bytes);
  return core::fail(fmt::format("{}: not an STL file: expected text with 'solid' or {} bytes of header, found {}",
                                job.file(), kHeaderBytes,
                                other_text ? "other text" : fmt::format("{} bytes", bytes.size())));
}

}  // namespace

core::Expected<ImportReport> read_stl(std::span<const std::byte> bytes, const std::filesystem::path& path,
                                      core::Scene& scene, core::NodeId parent, const ImportOptions& options) {
  return run_import(path.filename().string(), scene, parent, options, frame_of(options),
                    [&](ImportJob& job) -> core::Expected<void> {
                      job.report().bytes = bytes.size();
                      return read_either_form(job, bytes);
                    });
}

}  // namespace sightline::importers
