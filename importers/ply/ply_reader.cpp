#include "sightline/importers/ply/internal/ply_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "sightline/importers/internal/byte_order.h"
#include "sightline/importers/internal/face_colours.h"
#include "sightline/importers/internal/import_job.h"
#include "sightline/importers/internal/text_scanner.h"
#include "sightline/importers/ply/internal/ply_header.h"

namespace sightline::importers {
namespace {

using ply::Element;
using ply::Property;
using ply::Scalar;

/// What a property means to the reader. Roles before kScalarRoles are numbers of a record.
enum Role : std::uint8_t {
  kX,
  kY,
  kZ,
  kNormalX,
  kNormalY,
  kNormalZ,
  kRed,
  kGreen,
  kBlue,
  kAlpha,
  kScalarRoles,
  kCorners = kScalarRoles,
  kSkipped,
};

struct NamedRole {
  std::string_view name;
  Role role;
};
constexpr NamedRole kVertexRoles[] = {{"x", kX},
                                      {"y", kY},
                                      {"z", kZ},
                                      {"nx", kNormalX},
                                      {"ny", kNormalY},
                                      {"nz", kNormalZ},
                                      {"red", kRed},
                                      {"green", kGreen},
                                      {"blue", kBlue},
                                      {"alpha", kAlpha},
                                      {"diffuse_red", kRed},
                                      {"diffuse_green", kGreen},
                                      {"diffuse_blue", kBlue}};
constexpr NamedRole kFaceRoles[] = {{"vertex_indices", kCorners},
                                    {"vertex_index", kCorners},
                                    {"red", kRed},
                                    {"green", kGreen},
                                    {"blue", kBlue},
                                    {"alpha", kAlpha}};
constexpr NamedRole kStripRoles[] = {{"vertex_indices", kCorners}, {"vertex_index", kCorners}};

struct Field {
  Scalar type;
  std::optional<Scalar> count;
  Role role;
};

/// How an element is read: each role at most once; properties without a role are skipped.
struct Layout {
  Layout(const Element& element, std::span<const NamedRole> roles) {
    for (const Property& property : element.properties) {
      Role role = kSkipped;
      for (const NamedRole& known : roles)
        if (known.name == property.name && !has(known.role) && property.count.has_value() == (known.role == kCorners))
          role = known.role;
      if (role != kSkipped) present[role] = true;
      if (role >= kRed && role <= kAlpha) colour_scale[role - kRed] = scale_of(property.type);
      fields.push_back({property.type, property.count, role});
    }
  }
  bool has(Role role) const { return present[role]; }
  bool has_all(Role first, Role last) const {
    return std::all_of(present.begin() + first, present.begin() + last + 1, [](bool b) { return b; });
  }

  std::vector<Field> fields;
  std::array<bool, kSkipped> present{};
  std::array<double, 4> colour_scale{1.0, 1.0, 1.0, 1.0};

 private:
  /// The factor that scales to 0…255.
  static double scale_of(Scalar type) {
    if (type == Scalar::kUint16) return 1.0 / 257.0;
    return type == Scalar::kFloat || type == Scalar::kDouble ? 255.0 : 1.0;
  }
};

struct Record {
  std::array<double, kScalarRoles> values{};

  core::dvec3 vector(Role first) const { return {values[first], values[first + 1], values[first + 2]}; }
  PackedColour colour(const Layout& layout) const {
    std::array<std::uint32_t, 4> channels{0, 0, 0, 255};
    for (std::size_t i = 0; i < (layout.has(kAlpha) ? 4 : 3); ++i) {
      const double value = values[kRed + i] * layout.colour_scale[i];
      channels[i] = value > 0.0 ? std::uint32_t(std::lround(std::min(value, 255.0))) : 0;  // 0 for NaN
    }
    return pack_colour(channels[0], channels[1], channels[2], channels[3]);
  }
};

/// Numbers of a binary file.
template <std::endian kOrder>
class BinarySource {
 public:
  BinarySource(std::span<const std::byte> file, std::size_t begin) : file_(file), at_(begin) {}

  /// False at the end of the data.
  bool read(Scalar type, double& value) {
    if (ply::size_of(type) > left()) return false;
    const std::byte* const from = file_.data() + at_;
    at_ += ply::size_of(type);
    switch (type) {
      case Scalar::kInt8:
        value = load<std::int8_t, kOrder>(from);
        break;
      case Scalar::kUint8:
        value = load<std::uint8_t, kOrder>(from);
        break;
      case Scalar::kInt16:
        value = load<std::int16_t, kOrder>(from);
        break;
      case Scalar::kUint16:
        value = load<std::uint16_t, kOrder>(from);
        break;
      case Scalar::kInt32:
        value = load<std::int32_t, kOrder>(from);
        break;
      case Scalar::kUint32:
        value = load<std::uint32_t, kOrder>(from);
        break;
      case Scalar::kFloat:
        value = double(load<float, kOrder>(from));
        break;
      case Scalar::kDouble:
        value = load<double, kOrder>(from);
        break;
    }
    return true;
  }
  bool skip(Scalar type, std::uint64_t count) {
    if (count > left() / ply::size_of(type)) return false;
    at_ += count * ply::size_of(type);
    return true;
  }
  /// Skips all records of an element at once, if they are of one size and all there.
  bool skip_records(const Element& element) {
    if (element.has_lists() || element.count > most_records(element)) return false;
    at_ += element.count * element.least_bytes();
    return true;
  }

  /// Most records that the rest of the file can hold. The element must have properties.
  std::uint64_t most_records(const Element& element) const { return left() / element.least_bytes(); }
  std::uint64_t most_values(Scalar type) const { return left() / ply::size_of(type); }

  std::uint64_t offset() const { return at_; }
  std::string where() { return fmt::format("byte {}", at_); }
  static std::uint64_t words_not_numbers() { return 0; }

 private:
  std::size_t left() const { return file_.size() - at_; }
  std::span<const std::byte> file_;
  std::size_t at_;
};

/// Numbers of a text file. Line breaks mean nothing: values follow each other.
class TextSource {
 public:
  TextSource(std::span<const std::byte> file, std::size_t begin)
      : scanner_(file.subspan(begin)),
        size_(file.size()),
        begin_(begin),
        header_lines_(std::uint64_t(std::count(file.begin(), file.begin() + std::ptrdiff_t(begin), std::byte{'\n'}))) {}
  bool read(Scalar, double& value) {
    const auto found = scanner_.number(value);
    if (found == TextScanner::Found::kOther) ++words_not_numbers_;
    return found != TextScanner::Found::kEnd;
  }
  bool skip(Scalar, std::uint64_t count) {
    for (std::uint64_t i = 0; i < count; ++i)
      if (scanner_.word().empty()) return false;
    return true;
  }
  static bool skip_records(const Element&) { return false; }

  // A number takes at least two bytes, the last one perhaps one.
  std::uint64_t most_records(const Element& element) const { return left() / (2 * element.properties.size()) + 1; }
  std::uint64_t most_values(Scalar) const { return left() / 2 + 1; }

  std::uint64_t offset() const { return begin_ + scanner_.offset(); }
  std::string where() { return fmt::format("line {}", header_lines_ + scanner_.line()); }
  std::uint64_t words_not_numbers() const { return words_not_numbers_; }

 private:
  std::uint64_t left() const { return size_ - offset(); }
  TextScanner scanner_;
  std::size_t size_, begin_;  // of the file; of the data
  std::uint64_t header_lines_, words_not_numbers_ = 0;
};

template <class Source>
class PlyBody {
 public:
  PlyBody(ImportJob& job, const ply::Header& header, Source source, std::size_t file_size)
      : job_(job), header_(header), source_(std::move(source)), file_size_(file_size) {}

  core::Expected<void> run() {
    if (auto found = find_vertices(); !found) return found;
    for (const Element& element : header_.elements) {
      if (ended_) break;
      if (element.properties.empty() || element.count == 0) continue;
      if (auto read = read_element(element); !read) return read;
    }
    add_to_scene();
    return {};
  }

 private:
  core::Expected<void> find_vertices() {
    for (const Element& element : header_.elements) {
      if (!vertices_ && element.name == "vertex" && Layout(element, kVertexRoles).has_all(kX, kZ)) vertices_ = &element;
      if (!vertices_ && is_faces(element))
        return core::fail(fmt::format("{}: expected the element 'vertex', with the properties x, y and z, before '{}'",
                                      job_.file(), element.name));
    }
    if (!vertices_)
      return core::fail(fmt::format("{}: expected an element 'vertex' with the properties x, y and z", job_.file()));
    const std::uint64_t vertices = std::min(vertices_->count, source_.most_records(*vertices_));
    if (vertices >= core::kNone)
      return core::fail(
          fmt::format("{}: expected fewer than {} vertices, found {}", job_.file(), core::kNone, vertices));
    return {};
  }

  static bool is_faces(const Element& element) { return element.name == "face" || element.name == "tristrips"; }

  core::Expected<void> read_element(const Element& element) {
    if (&element == vertices_) return read_vertices(element);
    if (is_faces(element)) return read_faces(element);
    if (source_.skip_records(element)) return {};
    return for_each_record(element, Layout(element, {}), [](const Record&) {});
  }

  core::Expected<void> read_vertices(const Element& element) {
    const Layout layout(element, kVertexRoles);
    const bool normals = layout.has_all(kNormalX, kNormalZ), colours = layout.has_all(kRed, kBlue);
    const std::size_t most = std::min(element.count, source_.most_records(element));
    mesh_.positions.reserve(most);
    if (normals) mesh_.normals.reserve(most);
    return for_each_record(element, layout, [&](const Record& record) {
      mesh_.positions.push_back(record.vector(kX));
      if (normals) mesh_.normals.emplace_back(record.vector(kNormalX));
      if (colours) vertex_colours_.add(record.colour(layout));
    });
  }

  core::Expected<void> read_faces(const Element& element) {
    const bool strips = element.name == "tristrips";
    const Layout layout(element, strips ? std::span<const NamedRole>(kStripRoles) : kFaceRoles);
    if (!layout.has(kCorners)) {
      job_.warn(source_.offset(), fmt::format("element '{}' has no list vertex_indices: left out", element.name));
      return for_each_record(element, layout, [](const Record&) {});
    }
    const bool colours = layout.has_all(kRed, kBlue);
    if (colours) face_colours_.resize(mesh_.face_count(), kNoColour);
    if (!strips) reserve_triangles(element);
    return for_each_record(element, layout, [&](const Record& record) {
      if (strips) {
        add_strip();
      } else {
        mesh_.corners.insert(mesh_.corners.end(), corners_.begin(), corners_.end());
        mesh_.end_face(std::uint32_t(corners_.size()));
      }
      if (colours || !face_colours_.empty())
        face_colours_.resize(mesh_.face_count(), colours ? record.colour(layout) : kNoColour);
    });
  }

  void reserve_triangles(const Element& element) {
    const std::uint64_t most = source_.most_records(element);
    mesh_.corners.reserve(mesh_.corners.size() + 3 * std::min(element.count, most));
  }

  /// Every second triangle of a strip runs the other way.
  void add_strip() {
    std::size_t begin = 0;
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      if (corners_[i] == core::kNone) begin = i + 1;
      if (i < begin + 2) continue;
      const std::size_t odd = (i - begin) & 1;
      for (const std::size_t corner : {i - 2 + odd, i - 1 - odd, i}) mesh_.corners.push_back(corners_[corner]);
      mesh_.end_face(3);
    }
  }

  /// Calls take(record) for each record whose corners exist; corners_ holds them during the call.
  template <class Take>
  core::Expected<void> for_each_record(const Element& element, const Layout& layout, Take&& take) {
    constexpr std::uint64_t kBetweenProgress = 4096;
    const bool strips = element.name == "tristrips";
    for (std::uint64_t i = 0; i < element.count; ++i) {
      if (i % kBetweenProgress == 0)
        if (auto asked = job_.progress(0.7 * double(source_.offset()) / double(file_size_)); !asked) return asked;
      const std::uint64_t words = source_.words_not_numbers();
      Record record;
      if (!read_record(layout, record)) return end_early(element, i);
      if (source_.words_not_numbers() != words)
        if (auto told = damage(fmt::format("expected numbers in '{}' {}, found another word", element.name, i)); !told)
          return told;
      if (!corners_exist(strips)) {
        auto told = damage(fmt::format("expected vertices from 0 to {} in '{}' {}, found another; it is left out",
                                       std::int64_t(mesh_.positions.size()) - 1, element.name, i));
        if (!told) return told;
        continue;
      }
      take(record);
    }
    return {};
  }

  bool corners_exist(bool strips) const {
    return std::all_of(corners_.begin(), corners_.end(), [&](std::uint32_t corner) {
      return corner < mesh_.positions.size() || (strips && corner == core::kNone);
    });
  }

  /// False when the data end first, or when a list's length is invalid.
  bool read_record(const Layout& layout, Record& record) {
    corners_.clear();
    for (const Field& field : layout.fields) {
      double value = 0.0;
      if (!source_.read(field.count.value_or(field.type), value)) return false;
      if (field.count) {
        if (!(value >= 0.0) || value != std::floor(value) || value >= double(core::kNone)) return false;
        if (!(field.role == kCorners ? read_corners(field.type, std::uint64_t(value))
                                     : source_.skip(field.type, std::uint64_t(value))))
          return false;
      } else if (field.role != kSkipped) {
        record.values[field.role] = value;
      }
    }
    return true;
  }

  bool read_corners(Scalar type, std::uint64_t count) {
    if (count > source_.most_values(type)) return false;
    for (std::uint64_t i = 0; i < count; ++i) {
      double value = 0.0;
      if (!source_.read(type, value)) return false;
      // An invalid index becomes one that no vertex has; -1 becomes kNone, the end of a strip.
      const bool whole = value >= -1.0 && value < double(core::kNone) && value == std::floor(value);
      corners_.push_back(whole ? std::uint32_t(std::int64_t(value)) : core::kNone - 1);
    }
    return true;
  }

  core::Expected<void> damage(const std::string& message) {
    return job_.damage(source_.offset(), fmt::format("{}: {}", source_.where(), message));
  }

  core::Expected<void> end_early(const Element& element, std::uint64_t read) {
    ended_ = true;
    return damage(fmt::format("expected {} of '{}', found the file's end or a list of no length after {}",
                              element.count, element.name, read));
  }

  void add_to_scene() {
    if (mesh_.face_count() == 0) {
      job_.warn(0, fmt::format("no faces: {} points are not imported", mesh_.positions.size()));
    } else if (std::any_of(face_colours_.begin(), face_colours_.end(), [](auto c) { return c != kNoColour; })) {
      add_coloured_meshes(job_, job_.file_node(), mesh_, face_colours_, job_.file());
    } else {
      job_.add_mesh(job_.file_node(), mesh_, job_.file(), {},
                    add_colour_material(job_.scene(), vertex_colours_.average()));
    }
  }

  ImportJob& job_;
  const ply::Header& header_;
  Source source_;
  std::size_t file_size_;
  const Element* vertices_ = nullptr;
  bool ended_ = false;  // the data ended before the header's counts were met
  PolygonMesh mesh_;
  std::vector<std::uint32_t> corners_;  // of the record being read
  std::vector<PackedColour> face_colours_;
  ColourSum vertex_colours_;
};

template <class Source>
core::Expected<void> read_body(ImportJob& job, std::span<const std::byte> bytes, const ply::Header& header) {
  return PlyBody<Source>(job, header, Source(bytes, header.size), bytes.size()).run();
}

}  // namespace

core::Expected<ImportReport> read_ply(std::span<const std::byte> bytes, const std::filesystem::path& path,
                                      core::Scene& scene, core::NodeId parent, const ImportOptions& options) {
  return run_import(path.filename().string(), scene, parent, options, frame_of(options),
                    [&](ImportJob& job) -> core::Expected<void> {
                      job.report().bytes = bytes.size();
                      const auto header = ply::parse_header(bytes);
                      if (!header) return core::fail(fmt::format("{}: {}", job.file(), header.error().message));
                      switch (header->encoding) {
                        case ply::Encoding::kAscii:
                          return read_body<TextSource>(job, bytes, *header);
                        case ply::Encoding::kLittleEndian:
                          return read_body<BinarySource<std::endian::little>>(job, bytes, *header);
                        case ply::Encoding::kBigEndian:
                          return read_body<BinarySource<std::endian::big>>(job, bytes, *header);
                      }
                      return {};
                    });
}

}  // namespace sightline::importers
