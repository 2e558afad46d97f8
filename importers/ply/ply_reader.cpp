#include "sightline/importers/ply/internal/ply_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "sightline/core/internal/ascii_case.h"
#include "sightline/importers/internal/counted_warnings.h"
#include "sightline/importers/internal/face_colours.h"
#include "sightline/importers/internal/import_job.h"
#include "sightline/importers/internal/text_encoding.h"
#include "sightline/importers/internal/text_scanner.h"
#include "sightline/importers/ply/internal/ply_header.h"

namespace sightline::importers {
namespace {

using core::dvec3;
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
constexpr NamedRole kVertexRoles[] = {{"x", kX},        {"y", kY},        {"z", kZ},
                                      {"nx", kNormalX}, {"ny", kNormalY}, {"nz", kNormalZ}};
constexpr NamedRole kFaceRoles[] = {{"vertex_indices", kCorners}, {"vertex_index", kCorners}};
/// Names that programs give to red, green, blue and alpha, the commonest first.
constexpr std::array<std::string_view, 4> kColourNames[] = {
    {"red", "green", "blue", "alpha"},
    {"diffuse_red", "diffuse_green", "diffuse_blue", "diffuse_alpha"},
    {"r", "g", "b", "a"}};

struct Field {
  Scalar type;
  std::optional<Scalar> count;
  Role role;
};

/// How an element is read: each role at most once; properties without a role are skipped.
struct Layout {
  Layout(const Element& element, std::span<const NamedRole> roles) {
    for (const Property& property : element.properties) fields.push_back({property.type, property.count, kSkipped});
    for (const NamedRole& known : roles) find(element, known.name, known.role);
    for (const auto& names : kColourNames) {
      Layout with = *this;
      for (std::size_t i = 0; i < names.size(); ++i) with.find(element, names[i], Role(kRed + i));
      with.find(element, "alpha", kAlpha);
      if (!with.has_all(kRed, kBlue)) continue;
      *this = std::move(with);
      break;
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
  /// Gives the role to the first property of that name, unless another one has it.
  void find(const Element& element, std::string_view name, Role role) {
    for (std::size_t i = 0; i < fields.size() && !has(role); ++i) {
      if (!core::same_but_for_case(element.properties[i].name, name) ||
          fields[i].count.has_value() != (role == kCorners))
        continue;
      fields[i].role = role;
      present[role] = true;
      if (role >= kRed && role <= kAlpha) colour_scale[role - kRed] = scale_of(fields[i].type);
    }
  }
  /// The factor that scales to 0…255.
  static double scale_of(Scalar type) {
    if (type == Scalar::kUint16) return 1.0 / 257.0;
    return type == Scalar::kFloat || type == Scalar::kDouble ? 255.0 : 1.0;
  }
};

bool is_coordinate(Role role) {
  return role <= kZ;
}
/// Without these there is no vertex and no face. All else may be lost alone.
bool is_needed(Role role) {
  return is_coordinate(role) || role == kCorners;
}

struct Record {
  std::array<double, kScalarRoles> values{};
  bool lost_colour = false;

  /// Notes that a value is not there, or is another word.
  void lose(Role role) {
    if (role < kScalarRoles) values[role] = std::numeric_limits<double>::quiet_NaN();
    lost_colour = lost_colour || (role >= kRed && role <= kAlpha);
  }

  dvec3 vector(Role first) const { return {values[first], values[first + 1], values[first + 2]}; }
  PackedColour colour(const Layout& layout) const {
    if (lost_colour) return kNoColour;
    std::array<std::uint32_t, 4> channels{0, 0, 0, 255};
    for (std::size_t i = 0; i < (layout.has(kAlpha) ? 4 : 3); ++i) {
      const double value = values[kRed + i] * layout.colour_scale[i];
      channels[i] = value > 0.0 ? std::uint32_t(std::lround(std::min(value, 255.0))) : 0;  // 0 for NaN
    }
    return pack_colour(channels[0], channels[1], channels[2], channels[3]);
  }
};

/// Numbers of a binary file. Records follow each other without anything between.
template <std::endian kOrder>
class BinarySource {
 public:
  static constexpr bool kLines = false;
  using Found = TextScanner::Found;

  BinarySource(std::span<const std::byte> file, std::size_t begin) : file_(file), at_(begin) {}

  static bool begin_record() { return true; }
  static void end_record(CountedWarnings&) {}

  /// kEnd at the end of the data.
  Found read(Scalar type, double& value) {
    if (size_of(type) > left()) return Found::kEnd;
    with_type(type, [&](auto zero) { value = next<decltype(zero)>(); });
    return Found::kNumber;
  }
  /// Calls take(value) for each of so many values. False where the data end first.
  template <class Take>
  bool read_list(Scalar type, std::uint64_t count, Take&& take) {
    if (count > left() / size_of(type)) return false;
    with_type(type, [&](auto zero) {
      for (std::uint64_t i = 0; i < count; ++i) take(next<decltype(zero)>());
    });
    return true;
  }
  bool skip(Scalar type, std::uint64_t count) {
    if (count > left() / size_of(type)) return false;
    at_ += count * size_of(type);
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

  /// Bytes behind the last record, but for space and zeros.
  std::uint64_t left_over() const {
    std::size_t end = file_.size();
    while (end > at_ && (file_[end - 1] == std::byte{0} || is_space(char(file_[end - 1])))) --end;
    return end - at_;
  }

  std::uint64_t offset() const { return at_; }
  std::string where() { return fmt::format("byte {}", at_); }

 private:
  template <class T>
  double next() {
    const T value = load<T, kOrder>(file_.data() + at_);
    at_ += sizeof(T);
    return double(value);
  }
  std::size_t left() const { return file_.size() - at_; }
  std::span<const std::byte> file_;
  std::size_t at_;
};

/// Numbers of a text file, a line for each record.
class TextSource {
 public:
  static constexpr bool kLines = true;
  using Found = TextScanner::Found;

  TextSource(std::span<const std::byte> file, std::size_t begin)
      : scanner_(file.subspan(begin)),
        size_(file.size()),
        begin_(begin),
        header_lines_(std::uint64_t(std::count(file.begin(), file.begin() + std::ptrdiff_t(begin), std::byte{'\n'}))) {}

  /// Goes on to the next line with data. False at the end of the file.
  bool begin_record() {
    for (;;) {
      if (!scanner_.at_line_end()) {
        if (!at_comment()) {
          record_ = scanner_.rest();
          return true;
        }
        scanner_.rest_of_line();
        ++comments_;
      } else if (in_line_) {
        in_line_ = false;  // of the record before
      } else {
        ++blank_;
      }
      if (!scanner_.next_line()) return false;
    }
  }
  /// Passes what is left of the record's line.
  void end_record(CountedWarnings& habits) {
    in_line_ = true;
    if (blank_ + comments_ > 0) {
      habits.add("comments and empty lines among the data are skipped", offset(), [&] { return where(); });
      blank_ = comments_ = 0;
    }
    if (scanner_.at_line_end()) return;
    const char next = scanner_.rest().front();
    const bool number = (next >= '0' && next <= '9') || next == '-' || next == '+' || next == '.';
    habits.add(number ? "numbers beyond an element's own are ignored" : "text behind an element's numbers is ignored",
               offset(), [&] { return where(); });
    scanner_.rest_of_line();
  }
  bool at_line_end() { return scanner_.at_line_end(); }
  bool at_file_end() { return scanner_.at_line_end() && scanner_.rest().empty(); }
  /// Passes the record's line. True if a word of it is a number.
  bool pass_line() {
    again(false);
    in_line_ = true;
    bool number = false;
    double ignored = 0.0;
    for (Found found; (found = scanner_.number_in_line(ignored)) != Found::kEnd;)
      number = number || found == Found::kNumber;
    return number;
  }
  /// Records to come keep to their lines.
  void stay_in_line() { goes_on_ = false; }
  /// Goes back to the record's begin. `goes_on`: whether it may go on in the next line.
  void again(bool goes_on) {
    scanner_.back_to(record_);
    goes_on_ = goes_on;
  }

  /// kEnd at the line's end, unless the record may go on in the next line.
  Found read(Scalar, double& value) {
    if (goes_on_) [[unlikely]]
      return scanner_.number(value);
    return scanner_.number_in_line(value);
  }
  template <class Take>
  bool read_list(Scalar type, std::uint64_t count, Take&& take) {
    if (count > left() / 2 + 1) return false;
    double value = 0.0;
    for (std::uint64_t i = 0; i < count; ++i) {
      if (read(type, value) == Found::kEnd) return false;
      take(value);
    }
    return true;
  }
  bool skip(Scalar type, std::uint64_t count) {
    return read_list(type, count, [](double) {});
  }
  static bool skip_records(const Element&) { return false; }

  // A number takes at least two bytes, the last one perhaps one.
  std::uint64_t most_records(const Element& element) const { return left() / (2 * element.properties.size()) + 1; }

  /// Bytes behind the last record, but for space.
  std::uint64_t left_over() {
    const bool more = begin_record();
    return more ? left() : 0;
  }

  std::uint64_t offset() const { return begin_ + scanner_.offset(); }
  std::string where() { return fmt::format("line {}", header_lines_ + scanner_.line()); }

 private:
  std::uint64_t left() const { return size_ - offset(); }
  bool at_comment() const {
    const std::string_view rest = scanner_.rest();
    if (rest[0] != 'c' && rest[0] != 'o' && rest[0] != '#' && rest[0] != '/') return false;
    const std::string_view word = rest.substr(0, rest.find_first_of(" \t\r\n"));
    return word == "comment" || word == "obj_info" || rest[0] == '#' || word.starts_with("//");
  }

  TextScanner scanner_;
  std::string_view record_;   // the file from the record's begin on
  std::size_t size_, begin_;  // of the file; of the data
  std::uint64_t header_lines_, blank_ = 0, comments_ = 0;
  bool in_line_ = false;  // behind a record, whose line's end is not passed
  bool goes_on_ = false;
};

template <class Source>
class PlyBody {
 public:
  PlyBody(ImportJob& job, const ply::Header& header, Source source, std::size_t file_size)
      : job_(job), header_(header), source_(std::move(source)), file_size_(file_size) {}

  using Found = TextScanner::Found;

  core::Expected<void> run() {
    if (auto found = find_vertices(); !found) return found;
    for (const Element& element : header_.elements) {
      if (ended_) break;
      if (element.properties.empty() || element.count == 0) continue;
      if (auto read = read_element(element); !read) return read;
    }
    if (auto told = tell_of_rest(); !told) return told;
    habits_.list(job_);
    add_to_scene();
    return {};
  }

 private:
  /// A line of the header that was skipped may have been a property, of which the rest in the end tells.
  core::Expected<void> tell_of_rest() {
    const std::uint64_t rest = ended_ ? 0 : source_.left_over();
    if (rest == 0) return {};
    if (!Source::kLines && header_.skipped_lines)
      return damage(
          fmt::format("expected the file's end, found {} bytes that the header's lines do not explain", rest));
    job_.warn(source_.offset(), fmt::format("{}: {} bytes after the last element are ignored", source_.where(), rest));
    return {};
  }

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
    job_.warn(source_.offset(),
              fmt::format("element {}: {} are not imported", shown_word(element.name), element.count));
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
      if (colours) vertex_colours_.push_back(record.lost_colour ? kNoColour : record.colour(layout));
    });
  }

  core::Expected<void> read_faces(const Element& element) {
    const bool strips = element.name == "tristrips";
    const Layout layout(element, kFaceRoles);
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
        end_face(mesh_, std::uint32_t(corners_.size()));
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
      end_face(mesh_, 3);
    }
  }

  /// Calls take(record) for each record whose corners exist; corners_ holds them during the call.
  template <class Take>
  core::Expected<void> for_each_record(const Element& element, const Layout& layout, Take&& take) {
    constexpr std::uint64_t kBetweenProgress = 4096;
    const bool strips = element.name == "tristrips";
    Record record;  // each one has the same roles, and writes all of them
    for (std::uint64_t i = 0; i < element.count; ++i) {
      if (i % kBetweenProgress == 0)
        if (auto asked = job_.progress(0.7 * double(source_.offset()) / double(file_size_)); !asked) return asked;
      record.lost_colour = false;
      if (!source_.begin_record()) return end_early(element, i);
      const Read read = read_record(layout, record);
      if (read == Read::kEnd) return end_early(element, i);
      if (read == Read::kBroken) {
        const bool counts = is_record();
        if (auto told = damage(fmt::format("expected {} in {} {}, found {}", broken_->missed, shown_word(element.name),
                                           i, broken_->found));
            !told)
          return told;
        if (!counts) --i;
        if (!counts || &element != vertices_) continue;  // a vertex keeps its number
      } else {
        if (read == Read::kCut)
          if (auto told =
                  damage(fmt::format("expected all of {} {}, found the file's end", shown_word(element.name), i));
              !told)
            return told;
        source_.end_record(habits_);
      }
      if (!corners_exist(strips)) {
        auto told = damage(fmt::format("expected vertices from 0 to {} in {} {}, found another; it is left out",
                                       std::int64_t(mesh_.positions.size()) - 1, shown_word(element.name), i));
        if (!told) return told;
        continue;
      }
      take(record);
    }
    return {};
  }

  /// Whether a line is a record at all, though one that cannot be read: it holds some number. Passes the line.
  bool is_record() {
    if constexpr (Source::kLines) return source_.pass_line();
    return true;
  }

  bool corners_exist(bool strips) const {
    return std::all_of(corners_.begin(), corners_.end(), [&](std::uint32_t corner) {
      return corner < mesh_.positions.size() || (strips && corner == core::kNone);
    });
  }

  enum class Read : std::uint8_t {
    kWhole,   ///< but perhaps for what is not needed
    kCut,     ///< text: but the file ends within what is not needed
    kBroken,  ///< text: a coordinate or a corner is missing or is no number
    kEnd,     ///< binary: the data end first, or a list's length is invalid
  };
  struct Broken {
    std::string_view missed, found;
  };

  Read read_record(const Layout& layout, Record& record) {
    const bool whole = read_values(layout, record);
    if constexpr (Source::kLines) {
      const bool lost = !whole && !goes_on_in_next_line(layout, record) && !broken_;
      if (lost && source_.at_file_end()) return Read::kCut;
      if (lost) note("missing numbers, but for coordinates and corners, are left out");
      if (lost_words_) note("words in place of numbers, but for coordinates and corners, are left out");
      return broken_ ? Read::kBroken : Read::kWhole;
    }
    return whole ? Read::kWhole : Read::kEnd;
  }

  /// Some writers break long lines. A record that its line does not hold is read on where it then ends with a line.
  /// Where this does not help it is not tried again and again, as each try may read to the file's end.
  bool goes_on_in_next_line(const Layout& layout, Record& record) {
    constexpr int kMostTries = 16;
    if (failed_tries_ >= kMostTries) return false;
    source_.again(true);
    if (read_values(layout, record = {}) && !words_ && source_.at_line_end()) {
      note("an element that goes on in the next line is read");
      source_.stay_in_line();
      return true;
    }
    ++failed_tries_;
    source_.again(false);
    read_values(layout, record = {});
    return false;
  }

  /// False when the data or the line end first, or when a list's length is invalid. broken_ tells whether something
  /// needed is missing.
  bool read_values(const Layout& layout, Record& record) {
    corners_.clear();
    broken_.reset();
    words_ = lost_words_ = false;
    for (std::size_t i = 0; i < layout.fields.size(); ++i) {
      const Field& field = layout.fields[i];
      double value = 0.0;
      const Found found = source_.read(field.count.value_or(field.type), value);
      if (found == Found::kEnd) return lose_from(i, layout, record, {"more numbers", "the line's end"});
      if (Source::kLines && found == Found::kOther) words_ = true;
      if (field.count) {
        if (!(value >= 0.0) || value != std::floor(value) || value >= double(core::kNone))
          return lose_from(i, layout, record, {"a list's length", "something else"});
        if (!(field.role == kCorners ? read_corners(field.type, std::uint64_t(value))
                                     : source_.skip(field.type, std::uint64_t(value))))
          return lose_from(i, layout, record, {"a list as long as it says", "the line's end"});
      } else if (field.role != kSkipped) {
        record.values[field.role] = value;
        if (!Source::kLines || found != Found::kOther) continue;
        lose(field.role, record, {"numbers", "another word"});
        lost_words_ = lost_words_ || !is_needed(field.role);
      }
    }
    return true;
  }

  void lose(Role role, Record& record, const Broken& why) {
    record.lose(role);
    if (is_needed(role) && !broken_) broken_ = why;
  }
  bool lose_from(std::size_t first, const Layout& layout, Record& record, const Broken& why) {
    for (std::size_t i = first; i < layout.fields.size(); ++i) lose(layout.fields[i].role, record, why);
    return false;
  }

  bool read_corners(Scalar type, std::uint64_t count) {
    return source_.read_list(type, count, [this](double value) {
      // An invalid index becomes one that no vertex has; -1 becomes kNone, the end of a strip.
      const bool whole = value >= -1.0 && value < double(core::kNone) && value == std::floor(value);
      corners_.push_back(whole ? std::uint32_t(std::int64_t(value)) : core::kNone - 1);
    });
  }

  core::Expected<void> damage(const std::string& message) {
    return job_.damage(source_.offset(), fmt::format("{}: {}", source_.where(), message));
  }

  core::Expected<void> end_early(const Element& element, std::uint64_t read) {
    ended_ = true;
    return damage(fmt::format("expected {} of {}, found the file's end or a list of no length after {}", element.count,
                              shown_word(element.name), read));
  }

  void note(std::string_view what) {
    habits_.add(what, source_.offset(), [&] { return source_.where(); });
  }

  void add_to_scene() {
    if (mesh_.face_count() == 0) {
      job_.warn(0, fmt::format("no faces: {} points are not imported", mesh_.positions.size()));
    } else if (std::any_of(face_colours_.begin(), face_colours_.end(), [](auto c) { return c != kNoColour; })) {
      add_coloured_meshes(job_, job_.file_node(), mesh_, face_colours_, job_.file());
    } else {
      if (!vertex_colours_.empty()) face_colours_ = colours_from_vertices(mesh_, vertex_colours_);
      add_coloured_meshes(job_, job_.file_node(), mesh_, face_colours_, job_.file());
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
  std::optional<Broken> broken_;        // what its record misses
  bool words_ = false;                  // some of its values are words
  bool lost_words_ = false;             // of what is not needed
  int failed_tries_ = 0;                // to read on in the next line
  CountedWarnings habits_;
  std::vector<PackedColour> face_colours_;
  std::vector<PackedColour> vertex_colours_;
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
                      std::string decoded;
                      const auto file = without_utf16(job, bytes, decoded);
                      const auto header = ply::parse_header(file);
                      if (!header) return core::fail(fmt::format("{}: {}", job.file(), header.error().message));
                      for (const std::string& warning : header->warnings) job.warn(0, warning);
                      if (header->up) job.state_up(*header->up);
                      switch (header->encoding) {
                        case ply::Encoding::kAscii:
                          return read_body<TextSource>(job, file, *header);
                        case ply::Encoding::kLittleEndian:
                          return read_body<BinarySource<std::endian::little>>(job, file, *header);
                        case ply::Encoding::kBigEndian:
                          return read_body<BinarySource<std::endian::big>>(job, file, *header);
                      }
                      return {};
                    });
}

}  // namespace sightline::importers
