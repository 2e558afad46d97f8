#include "sightline/importers/stl/internal/stl_reader.h"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "sightline/importers/internal/byte_order.h"
#include "sightline/importers/internal/face_colours.h"
#include "sightline/importers/internal/import_job.h"
#include "sightline/importers/internal/text_scanner.h"
#include "sightline/importers/internal/vertex_welder.h"

namespace sightline::importers {
namespace {

using core::dvec3;

constexpr std::size_t kHeaderBytes = 84, kFacetBytes = 50;

template <class T>
T little(const std::byte* from) {
  return load<T, std::endian::little>(from);
}

char lower(char c) {
  return c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c;
}

/// Keywords come in any case.
bool is(std::string_view word, std::string_view keyword) {
  return word.size() == keyword.size() &&
         std::equal(word.begin(), word.end(), keyword.begin(), [](char a, char b) { return lower(a) == b; });
}

std::size_t claimed_facets(std::span<const std::byte> bytes) {
  return little<std::uint32_t>(bytes.data() + kHeaderBytes - 4);
}

bool is_text(std::span<const std::byte> bytes) {
  constexpr std::size_t kLookedAt = 512;
  const auto begin = bytes.first(std::min(kLookedAt, bytes.size()));
  return is(TextScanner(begin).word(), "solid") && std::find(begin.begin(), begin.end(), std::byte{0}) == begin.end();
}

// --- binary
// ------------------------------------------------------------------------------------------------------------

/// What attribute bytes mean in this file.
class AttributeColours {
 public:
  explicit AttributeColours(std::span<const std::byte> header) {
    const std::string_view text(reinterpret_cast<const char*>(header.data()), kHeaderBytes - 4);
    const std::size_t key = text.find("COLOR=");
    if (key == std::string_view::npos || key + 10 > text.size()) return;
    const auto byte = [&](std::size_t i) { return std::uint32_t(std::uint8_t(text[key + 6 + i])); };
    magics_ = true;
    default_ = pack_colour(byte(0), byte(1), byte(2), byte(3));
  }
  PackedColour operator()(std::uint16_t attribute) const {
    const auto channel = [&](int shift) {
      const std::uint32_t five = attribute >> shift & 31u;
      return five << 3 | five >> 2;
    };
    const bool bit_15 = (attribute & 0x8000u) != 0;
    if (magics_) return bit_15 ? default_ : pack_colour(channel(0), channel(5), channel(10));
    return bit_15 ? pack_colour(channel(10), channel(5), channel(0)) : kNoColour;
  }

 private:
  bool magics_ = false;
  PackedColour default_ = kNoColour;
};

core::Expected<void> check_size(ImportJob& job, std::span<const std::byte> bytes, std::size_t whole) {
  const std::size_t claimed = claimed_facets(bytes), body = bytes.size() - kHeaderBytes;
  if (claimed == whole && body == whole * kFacetBytes) return {};
  return job.damage(kHeaderBytes - 4, fmt::format("byte {}: expected {} facets of {} bytes, found {} bytes",
                                                  kHeaderBytes - 4, claimed, kFacetBytes, body));
}

core::Expected<void> read_binary(ImportJob& job, std::span<const std::byte> bytes) {
  const std::size_t facets = std::min(claimed_facets(bytes), (bytes.size() - kHeaderBytes) / kFacetBytes);
  if (auto checked = check_size(job, bytes, facets); !checked) return checked;
  if (3 * facets >= core::kNone)
    return core::fail(fmt::format("{}: expected fewer than {} facets, found {}", job.file(), core::kNone / 3, facets));

  const AttributeColours colour_of(bytes);
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

// --- text
// --------------------------------------------------------------------------------------------------------------

class TextReader {
 public:
  TextReader(ImportJob& job, std::span<const std::byte> bytes) : job_(job), scanner_(bytes) {}

  core::Expected<void> run() {
    for (std::string_view word; !(word = next()).empty();)
      if (auto done = statement(word); !done) return done;
    if (in_solid_) {
      if (auto told = unexpected("endsolid", {}); !told) return told;
      end_solid();
    }
    if (solids_ == 0) job_.warn(0, "no facets");
    return {};
  }

 private:
  core::Expected<void> statement(std::string_view word) {
    if (is(word, "facet") && in_solid_) return facet();
    if (is(word, "endsolid") && in_solid_) {
      scanner_.rest_of_line();
      end_solid();
      return {};
    }
    if (is(word, "solid")) {
      auto told = in_solid_ ? unexpected("endsolid before another solid", word) : core::Expected<void>{};
      if (in_solid_) end_solid();
      name_ = scanner_.rest_of_line();
      in_solid_ = true;
      lost_ = false;
      return told;
    }
    if (lost_) return {};
    return unexpected(in_solid_ ? "facet or endsolid" : "solid", word);
  }

  core::Expected<void> facet() {
    constexpr std::size_t kFacetsBetweenProgress = 1024;
    if (facets_++ % kFacetsBetweenProgress == 0)
      if (auto asked = job_.progress(0.7 * scanner_.share()); !asked) return asked;
    lost_ = false;
    std::array<dvec3, 3> corners;
    if (!take("normal")) return unexpected("normal", put_back_);
    for (int i = 0; i < 3; ++i) scanner_.word();
    if (!take("outer") || !take("loop")) return unexpected("outer loop", put_back_);
    for (dvec3& corner : corners) {
      if (!take("vertex")) return unexpected("vertex", put_back_);
      for (glm::length_t k = 0; k < 3; ++k)
        if (scanner_.number(corner[k]) != TextScanner::Found::kNumber)
          return unexpected("three numbers after vertex", "something else");
    }
    if (!take("endloop") || !take("endfacet")) return unexpected("endloop endfacet", put_back_);
    pending_.insert(pending_.end(), corners.begin(), corners.end());
    if (pending_.size() == VertexWelder::kBlock) weld_pending();
    return {};
  }

  std::string_view next() { return put_back_.empty() ? scanner_.word() : std::exchange(put_back_, {}); }

  /// Takes the next word if it is that keyword, else puts it back.
  bool take(std::string_view keyword) {
    const std::string_view word = scanner_.word();
    if (is(word, keyword)) return true;
    put_back_ = word;
    return false;
  }

  /// Reports damage. When lenient, words up to the next facet or solid are ignored from here on.
  core::Expected<void> unexpected(std::string_view expected, std::string_view found) {
    lost_ = true;
    return job_.damage(scanner_.offset(),
                       fmt::format("line {}: expected {}, found {}", scanner_.line(), expected,
                                   found.empty() ? "the file's end" : fmt::format("'{}'", found.substr(0, 40))));
  }

  void weld_pending() {
    welder_.add(pending_, mesh_.corners);
    pending_.clear();
  }

  void end_solid() {
    in_solid_ = false;
    weld_pending();
    if (mesh_.corners.empty()) {
      job_.warn(scanner_.offset(), fmt::format("line {}: solid '{}' has no facets", scanner_.line(), name_));
      return;
    }
    ++solids_;
    mesh_.positions = welder_.take_positions();
    const core::NodeId node = name_.empty() ? job_.file_node() : job_.scene().add_node(job_.file_node(), name_);
    job_.add_mesh(node, mesh_, name_.empty() ? std::string_view(job_.file()) : name_, {}, {}, scanner_.offset());
    mesh_ = {};
  }

  ImportJob& job_;
  TextScanner scanner_;
  std::string_view put_back_;
  bool in_solid_ = false;
  bool lost_ = false;  // after damage, until something begins
  std::string_view name_;
  std::uint64_t facets_ = 0, solids_ = 0;
  std::vector<dvec3> pending_;  // corners of whole facets
  VertexWelder welder_;
  PolygonMesh mesh_;
};

}  // namespace

core::Expected<ImportReport> read_stl(std::span<const std::byte> bytes, const std::filesystem::path& path,
                                      core::Scene& scene, core::NodeId parent, const ImportOptions& options) {
  return run_import(
      path.filename().string(), scene, parent, options, frame_of(options), [&](ImportJob& job) -> core::Expected<void> {
        job.report().bytes = bytes.size();
        const bool exact = bytes.size() >= kHeaderBytes &&
                           bytes.size() - kHeaderBytes == kFacetBytes * std::size_t{claimed_facets(bytes)};
        if (!exact && is_text(bytes)) return TextReader(job, bytes).run();
        if (bytes.size() >= kHeaderBytes) return read_binary(job, bytes);
        return core::fail(fmt::format("{}: not an STL file: expected 'solid' or {} bytes of header, found {} bytes",
                                      job.file(), kHeaderBytes, bytes.size()));
      });
}

}  // namespace sightline::importers
