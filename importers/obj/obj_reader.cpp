#include "sightline/importers/obj/internal/obj_reader.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <span>

#include <fmt/format.h>

#include "sightline/importers/internal/up_axis.h"
#include "sightline/importers/obj/internal/obj_model.h"

namespace sightline::importers::obj {
namespace {

TextScanner words_of(std::string_view line) {
  return TextScanner(std::as_bytes(std::span(line)));
}

/// Numbers of a corner as the file has them; 0 where there is none.
struct WrittenCorner {
  std::int64_t position = 0, normal = 0;
  bool wrong_normal = false;  ///< something else than a number stands in its place
};

/// Takes a number from the begin of a word. False if it begins with none.
bool take_index(std::string_view& word, std::int64_t& index) {
  const char* const from = word.data() + (word.starts_with('+') ? 1 : 0);
  const auto [stop, error] = std::from_chars(from, word.data() + word.size(), index);
  if (error != std::errc()) return false;
  word.remove_prefix(std::size_t(stop - word.data()));
  return true;
}

/// "V", "V/T", "V//N" and "V/T/N", where T and N may be missing behind their slash. Nothing when V is no number.
std::optional<WrittenCorner> corner_of(std::string_view word) {
  WrittenCorner corner;
  if (!take_index(word, corner.position) || (!word.empty() && word[0] != '/')) return {};
  if (word.empty()) return corner;
  const std::size_t second = word.find('/', 1);
  if (second == word.npos) return corner;
  word.remove_prefix(second + 1);
  corner.wrong_normal = !word.empty() && (!take_index(word, corner.normal) || !word.empty());
  return corner;
}

/// Converts an index from 1, or from -1 backwards, to an index from 0. Nothing when there is no such element.
std::optional<std::uint32_t> resolve(std::int64_t index, std::size_t count) {
  const auto size = std::int64_t(count);
  if (index == 0 || index > size || index < -size) return {};
  return std::uint32_t(index > 0 ? index - 1 : size + index);
}

bool is_usable(const core::dvec3& p) {
  return std::abs(p.x) <= kLargestCoordinate && std::abs(p.y) <= kLargestCoordinate &&
         std::abs(p.z) <= kLargestCoordinate;  // false for NaN
}

/// Statements that were dropped, replaced or left out.
struct Notices {
  Noticed bad_vertices, unusable_faces, small_faces, bad_normals, missing_normals, bad_colours, ignored;
  Noticed lines_left_out, points_left_out, forms_left_out, unknown;

  void warn(ImportJob& job) const {
    bad_vertices.warn(job, "vertices that are not three numbers, finite and within 1e36 (decimal points, not commas)");
    unusable_faces.warn(job, "faces dropped: they have such vertices");
    small_faces.warn(job, "faces dropped: fewer than 3 corners");
    bad_normals.warn(job, "normals that are no direction: faces have their own there");
    missing_normals.warn(job, "corners with a normal that does not exist: faces have their own there");
    bad_colours.warn(job, "colours of vertices that are not three finite numbers left out");
    ignored.warn(job, "vertices with something behind their coordinates that is no colour");
    lines_left_out.warn(job, "statements of lines (l) left out");
    points_left_out.warn(job, "statements of points (p) left out");
    forms_left_out.warn(job, "free-form curves and surfaces or calls left out");
    unknown.warn(job, "lines left out that begin with no word of the format");
  }
};

class ObjParser {
 public:
  ObjParser(ImportJob& job, std::string_view text, const std::filesystem::path& path)
      : job_(job), lines_(text), libraries_(job, path), decoder_(job) {}

  core::Expected<void> run() {
    std::uint64_t count = 0;
    for (std::string_view line; lines_.next(line);) {
      if (count++ % kLinesBetweenChecks == 0)
        if (auto checked = check(); !checked) return checked;
      statement(line);
      if (!refused_) return refused_;
    }
    if (model_.positions.empty())
      return core::fail(
          fmt::format("{}: not an OBJ file: expected vertex statements ('v x y z'), found none", job_.file()));
    noticed_.warn(job_);
    return add_to_scene(job_, model_, libraries_);
  }

 private:
  static constexpr std::uint64_t kLinesBetweenChecks = 1024;

  core::Expected<void> check() {
    constexpr std::size_t kMost = core::kNone - kLinesBetweenChecks;
    if (model_.positions.size() >= kMost || model_.normals.size() >= kMost)
      return core::fail(fmt::format("{}: expected at most {} vertices and normals", job_.file(), kMost));
    return job_.progress(0.9 * lines_.share());
  }

  void statement(std::string_view line) {
    TextScanner words = words_of(line);
    const std::string_view keyword = words.word();
    if (keyword.empty()) return;
    if (keyword[0] == '#') return comment(line);
    const std::string_view rest = line.substr(words.offset());
    if (keyword == "v")
      vertex(rest.substr(0, rest.find('#')));
    else if (keyword == "f" || keyword == "fo")
      face(rest.substr(0, rest.find('#')));
    else if (keyword == "vn")
      normal(rest.substr(0, rest.find('#')));
    else if (keyword != "vt")
      other_statement(keyword, trimmed(rest));
  }

  void comment(std::string_view line) {
    if (!model_.positions.empty()) return;
    if (const auto up = up_axis_in_comment(line)) job_.state_up(*up);
  }

  void other_statement(std::string_view keyword, std::string_view rest) {
    if (keyword == "o")
      begin_object(name_without_comment(rest));
    else if (keyword == "g")
      begin_place({place_.object, number_of(name_without_comment(rest), number_of_name_), place_.material});
    else if (keyword == "usemtl")
      begin_place({place_.object, place_.group, number_of(rest, number_of_material_)});
    else if (keyword == "mtllib")
      libraries_.open(rest, lines_);
    else
      content_left_out(keyword);
  }

  void content_left_out(std::string_view keyword) {
    if (keyword == "l")
      noticed_.lines_left_out.add(lines_);
    else if (keyword == "p")
      noticed_.points_left_out.add(lines_);
    else if (keyword == "curv" || keyword == "curv2" || keyword == "surf" || keyword == "call")
      noticed_.forms_left_out.add(lines_, keyword);
    else if (!means_nothing_here(keyword))
      noticed_.unknown.add(lines_, keyword);
  }

  /// Smoothing, display and what belongs to free-form shapes.
  static bool means_nothing_here(std::string_view keyword) {
    constexpr std::string_view kWords[] = {
        "s",     "vp",    "cstype", "deg", "bmat",  "step",     "parm", "trim",   "hole",       "scrv",
        "sp",    "end",   "con",    "mg",  "bevel", "c_interp", "lod",  "maplib", "d_interp",   "usemap",
        "ctech", "stech", "res",    "cdc", "cdp",   "bzp",      "bsp",  "csh",    "shadow_obj", "trace_obj"};
    return std::find(std::begin(kWords), std::end(kWords), keyword) != std::end(kWords);
  }

  void vertex(std::string_view rest) {
    TextScanner words = words_of(rest);
    core::dvec3 p;
    for (int i = 0; i < 3; ++i) words.number(p[i]);
    if (!is_usable(p)) {
      p = core::dvec3(std::numeric_limits<double>::quiet_NaN());  // which tells its faces
      noticed_.bad_vertices.add(lines_, trimmed(rest));
    }
    model_.positions.push_back(p);
    behind_position(words, rest);
  }

  /// A weight, which only curves have, or a colour, perhaps with an alpha.
  void behind_position(TextScanner& words, std::string_view rest) {
    std::array<double, 4> more{};
    std::size_t count = 0;
    while (count < more.size() && words.number(more[count]) != TextScanner::Found::kEnd) ++count;
    if (count >= 3)
      colour({more[0], more[1], more[2]}, rest);
    else if (count == 2 || (count == 1 && std::isnan(more[0])))
      noticed_.ignored.add(lines_, trimmed(rest));
  }

  void colour(const core::vec3& channels, std::string_view rest) {
    constexpr float kAbsent = std::numeric_limits<float>::quiet_NaN();
    const bool bad = !core::is_finite(core::dvec3(channels));
    if (bad) noticed_.bad_colours.add(lines_, trimmed(rest));
    model_.colours.resize(model_.positions.size(), core::vec3(kAbsent));
    if (!bad) model_.colours.back() = channels;
  }

  void normal(std::string_view rest) {
    TextScanner words = words_of(rest);
    core::dvec3 n;
    for (int i = 0; i < 3; ++i) words.number(n[i]);
    const core::vec3 direction(n);
    const double length = glm::length(core::dvec3(direction));
    const bool good = length > 0.0 && std::isfinite(length);
    if (!good) noticed_.bad_normals.add(lines_, trimmed(rest));
    model_.normals.push_back(good ? direction : core::vec3(0.0f));
  }

  void face(std::string_view rest) {
    corners_.clear();
    bool usable = true;
    TextScanner words = words_of(rest);
    for (std::string_view word; !(word = words.word()).empty();) {
      const auto written = corner_of(word);
      const auto position = resolve(written ? written->position : 0, model_.positions.size());
      if (!position) return bad_corner(word);
      if (noticed_.bad_vertices.count > 0) usable = usable && is_usable(model_.positions[*position]);
      corners_.push_back({*position, normal_of(*written, word)});
    }
    if (corners_.size() < 3)
      noticed_.small_faces.add(lines_, trimmed(rest));
    else if (!usable)
      noticed_.unusable_faces.add(lines_);
    else
      add_face();
  }

  void bad_corner(std::string_view word) {
    const std::string_view index = word.substr(0, word.find('/'));
    std::int64_t number = 0;
    std::string_view left = index;
    const bool is_number = take_index(left, number) && left.empty();
    refused_ = job_.damage(
        lines_.offset(),
        fmt::format("line {}: expected a vertex index within the {} vertices so far, found {}{}", lines_.number(),
                    model_.positions.size(), is_number ? std::string(index) : excerpt(index),
                    job_.options().lenient ? "; face left out" : ""));
  }

  std::uint32_t normal_of(const WrittenCorner& corner, std::string_view word) {
    if (corner.normal == 0 && !corner.wrong_normal) return core::kNone;
    const auto normal = resolve(corner.wrong_normal ? 0 : corner.normal, model_.normals.size());
    if (!normal) {
      noticed_.missing_normals.add(lines_, word);
      return core::kNone;
    }
    const bool bad = noticed_.bad_normals.count > 0 && model_.normals[*normal] == core::vec3(0.0f);
    return bad ? core::kNone : *normal;
  }

  void add_face() {
    Part& part = current_part();
    part.corners.insert(part.corners.end(), corners_.begin(), corners_.end());
    end_face(part, std::uint32_t(corners_.size()));
  }

  Part& current_part() {
    if (object_begins_) settle_object();
    if (part_ != core::kNone) return model_.parts[part_];
    const auto [at, added] = number_of_part_.try_emplace(place_, std::uint32_t(model_.parts.size()));
    if (added) model_.parts.push_back({place_, lines_.offset(), lines_.number(), {}, {}});
    part_ = at->second;
    return model_.parts[part_];
  }

  void begin_object(std::string_view name) {
    if (place_.object != core::kNone) vertices_of_object_[place_.object] = model_.positions.size();
    begin_place({.object = number_of(name, number_of_name_), .material = place_.material});
    object_begins_ = place_.object != core::kNone;
    object_name_ = name;
  }

  /// An object of a name that was there counts as another one if it brings vertices, and goes on with the former
  /// otherwise.
  void settle_object() {
    object_begins_ = false;
    const auto former = vertices_of_object_.find(place_.object);
    if (former == vertices_of_object_.end() || former->second == model_.positions.size()) return;
    const auto another = std::uint32_t(model_.names.size());
    model_.names.push_back({model_.names[place_.object].text, lines_.offset(), lines_.number()});
    number_of_name_[object_name_] = another;
    if (place_.group == place_.object) place_.group = another;
    place_.object = another;
  }

  void begin_place(const Place& place) {
    place_ = place;
    part_ = core::kNone;
  }

  using Numbers = std::map<std::string, std::uint32_t, std::less<>>;

  /// The number of a name; kNone for an empty one.
  std::uint32_t number_of(std::string_view name, Numbers& numbers) {
    if (name.empty()) return core::kNone;
    const auto known = numbers.find(name);
    if (known != numbers.end()) return known->second;
    const auto number = std::uint32_t(model_.names.size());
    model_.names.push_back({decoder_.decode(name, lines_.offset(), lines_.number()), lines_.offset(), lines_.number()});
    numbers.emplace(name, number);
    return number;
  }

  ImportJob& job_;
  StatementLines lines_;
  MaterialLibraries libraries_;
  NameDecoder decoder_;
  Model model_;
  Place place_;
  std::uint32_t part_ = core::kNone;  // of the present place; kNone after a change of it
  std::map<Place, std::uint32_t> number_of_part_;
  Numbers number_of_name_, number_of_material_;
  std::map<std::uint32_t, std::size_t> vertices_of_object_;  // how many there were when the next object began
  std::string object_name_;                                  // as written
  bool object_begins_ = false;                               // no face since its statement
  std::vector<Corner> corners_;                              // of one face
  core::Expected<void> refused_;
  Notices noticed_;
};

}  // namespace
}  // namespace sightline::importers::obj

namespace sightline::importers {

core::Expected<ImportReport> read_obj(std::span<const std::byte> bytes, const std::filesystem::path& path,
                                      core::Scene& scene, core::NodeId parent, const ImportOptions& options) {
  return run_import(path.filename().string(), scene, parent, options, frame_of(options), [&](ImportJob& job) {
    job.report().bytes = bytes.size();
    std::string decoded;
    const auto file = without_utf16(job, bytes, decoded);
    return obj::ObjParser(job, {reinterpret_cast<const char*>(file.data()), file.size()}, path).run();
  });
}

}  // namespace sightline::importers
