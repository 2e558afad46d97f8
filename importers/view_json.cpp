#include "sightline/importers/view_json.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <limits>
#include <optional>
#include <span>
#include <system_error>
#include <utility>
#include <vector>

#include "sightline/core/internal/atomic_file.h"
#include "sightline/importers/internal/json_text.h"

namespace sightline::importers {
namespace {

using core::dmat4;
using core::dvec3;
using core::Expected;
using core::fail;

constexpr int kMaxViewDepth = 64;
constexpr std::uintmax_t kMaxBytes = std::uintmax_t(256) << 20;
constexpr double kDegrees = 3.14159265358979323846 / 180.0;
constexpr double kLeastOrthoReach = 10'000.0;  // metres

/// Reads values below one object and keeps the first thing that is wrong; later reads then do nothing.
class Reader {
 public:
  explicit Reader(std::string_view source) : source_(source) {}

  bool ok() const { return error_.empty(); }
  core::Error error() const { return {error_}; }

  void complain(const std::string& pointer, const std::string& expected, const Json* found = nullptr) {
    if (!ok()) return;
    error_ = source_ + ": " + (pointer.empty() ? "/" : pointer) + ": expected " + expected;
    error_ += found ? ", found " + describe(*found) : ", which is missing";
  }

  /// The value under a key, or null. `object` must be an object.
  static const Json* find(const Json& object, const char* key) {
    const auto it = object.find(key);
    return it == object.end() ? nullptr : &*it;
  }

  bool object(const Json& value, const std::string& pointer) {
    if (!value.is_object()) complain(pointer, "an object", &value);
    return ok();
  }

  double number(const Json& object, const std::string& pointer, const char* key, std::optional<double> fallback = {}) {
    const Json* value = find(object, key);
    if (!value && fallback) return *fallback;
    return finite(value, pointer + "/" + key);
  }

  dvec3 vector(const Json& object, const std::string& pointer, const char* key, std::optional<dvec3> fallback = {}) {
    const Json* value = find(object, key);
    if (!value && fallback) return *fallback;
    const std::string here = pointer + "/" + key;
    if (!value || !value->is_array() || value->size() != 3) {
      complain(here, "an array of three numbers", value);
      return {};
    }
    dvec3 v(0.0);
    for (int i = 0; i < 3; ++i) v[i] = finite(&(*value)[std::size_t(i)], here + "/" + std::to_string(i));
    return v;
  }

 private:
  double finite(const Json* value, const std::string& pointer) {
    const bool good = value && value->is_number() && std::isfinite(value->get<double>());
    if (!good) complain(pointer, "a finite number", value);
    return good ? value->get<double>() : 0.0;
  }

  std::string source_, error_;
};

std::vector<core::Plane> read_sections(Reader& in, const Json& root) {
  std::vector<core::Plane> planes;
  const Json* list = Reader::find(root, "sections");
  if (!list) return planes;
  if (!list->is_array() || list->size() > core::kMaxSectionPlanes) {
    in.complain("/sections", "an array of at most " + std::to_string(core::kMaxSectionPlanes) + " planes", list);
    return planes;
  }
  for (std::size_t i = 0; i < list->size() && in.ok(); ++i) {
    const Json& plane = (*list)[i];
    const std::string pointer = "/sections/" + std::to_string(i);
    if (!in.object(plane, pointer)) break;
    planes.push_back({in.vector(plane, pointer, "n"), in.number(plane, pointer, "d")});
    if (in.ok() && planes.back().normal == dvec3(0.0))
      in.complain(pointer + "/n", "a normal other than zero", &plane["n"]);
  }
  return planes;
}

core::SectionMode read_section_mode(Reader& in, const Json& root) {
  const Json* mode = Reader::find(root, "section_mode");
  if (mode && *mode == "union") return core::SectionMode::kUnion;
  if (mode && *mode != "intersection") in.complain("/section_mode", "\"intersection\" or \"union\"", mode);
  return core::SectionMode::kIntersection;
}

std::uint32_t read_layers(Reader& in, const Json& root) {
  const Json* mask = Reader::find(root, "layers");
  if (!mask) return core::kDefaultLayerMask;
  constexpr std::uint64_t kMost = std::numeric_limits<std::uint32_t>::max();
  if (!mask->is_number_unsigned() || mask->get<std::uint64_t>() > kMost) {
    in.complain("/layers", "a whole number from 0 to 4294967295", mask);
    return 0;
  }
  return mask->get<std::uint32_t>();
}

core::Pose read_pose(Reader& in, const Json& object, const std::string& pointer, const dvec3& default_up) {
  return {in.vector(object, pointer, "eye"), in.vector(object, pointer, "target"),
          in.vector(object, pointer, "up", default_up)};
}

/// The projection of a view. The result counts only if `in` is still ok afterwards.
Expected<core::View> read_projection(Reader& in, const Json& root, const core::Pose& pose, double aspect) {
  const double near = in.number(root, "", "near");
  if (!Reader::find(root, "ortho_height")) {
    const double fovy = in.number(root, "", "fovy_deg"), far = in.number(root, "", "far", core::kInfiniteFar);
    return in.ok() ? core::View::perspective(pose, fovy * kDegrees, aspect, near, far) : tl::unexpected(in.error());
  }
  if (const Json* both = Reader::find(root, "fovy_deg")) in.complain("/fovy_deg", "nothing beside /ortho_height", both);
  const double height = in.number(root, "", "ortho_height");
  const double reach = std::max(kLeastOrthoReach, 10.0 * glm::length(pose.target - pose.eye));
  const double far = in.number(root, "", "far", near + reach);
  return in.ok() ? core::View::orthographic(pose, height, aspect, near, far) : tl::unexpected(in.error());
}

std::vector<core::CameraKey> read_keys(Reader& in, const Json& root) {
  std::vector<core::CameraKey> keys;
  const Json* list = Reader::find(root, "keys");
  if (!list || !list->is_array() || list->empty()) in.complain("/keys", "an array of at least one key", list);
  for (std::size_t i = 0; in.ok() && i < list->size(); ++i) {
    const Json& object = (*list)[i];
    const std::string pointer = "/keys/" + std::to_string(i);
    if (!in.object(object, pointer)) break;
    core::CameraKey key;
    key.time = in.number(object, pointer, "t");
    key.pose = read_pose(in, object, pointer, i > 0 ? keys.back().pose.up : dvec3(0.0, 0.0, 1.0));
    const bool inherits = i > 0 && !Reader::find(object, "fovy_deg");
    key.fovy = inherits ? keys.back().fovy : in.number(object, pointer, "fovy_deg") * kDegrees;
    keys.push_back(key);
  }
  return keys;
}

Expected<std::string> slurp(const std::filesystem::path& file) {
  const std::string where = file.string() + ": ";
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return fail(where + "no such file");
  if (std::filesystem::is_directory(file, error)) return fail(where + "expected a file, found a directory");
  const std::uintmax_t bytes = std::filesystem::file_size(file, error);
  if (error) return fail(where + "expected a regular file: " + error.message());
  if (bytes > kMaxBytes) return fail(where + "expected at most 256 MiB, found " + std::to_string(bytes) + " bytes");
  std::ifstream in(file, std::ios::binary);
  std::string text(bytes, '\0');
  if (!in.read(text.data(), std::streamsize(text.size()))) return fail(where + "cannot be read");
  return text;
}

Json triple(const dvec3& v) {
  return Json::array({v.x, v.y, v.z});
}

}  // namespace

Expected<core::View> parse_view(std::string_view json, double aspect, std::string_view source) {
  const Expected<Json> root = parse_json(json, source, kMaxViewDepth);
  if (!root) return tl::unexpected(root.error());
  Reader in(source);
  if (!in.object(*root, "")) return tl::unexpected(in.error());
  const core::Pose pose = read_pose(in, *root, "", dvec3(0.0, 0.0, 1.0));
  Expected<core::View> view = read_projection(in, *root, pose, aspect);
  const std::vector<core::Plane> sections = read_sections(in, *root);
  const core::SectionMode mode = read_section_mode(in, *root);
  const std::uint32_t layers = read_layers(in, *root);
  if (!in.ok()) return tl::unexpected(in.error());
  if (!view) return fail(std::string(source) + ": " + view.error().message);
  view->sections = sections;
  view->section_mode = mode;
  view->layers = layers;
  return view;
}

Expected<core::View> read_view(const std::filesystem::path& file, double aspect) {
  const Expected<std::string> text = slurp(file);
  if (!text) return tl::unexpected(text.error());
  return parse_view(*text, aspect, file.string());
}

Expected<core::CameraPath> parse_path(std::string_view json, std::string_view source) {
  const Expected<Json> root = parse_json(json, source, kMaxViewDepth);
  if (!root) return tl::unexpected(root.error());
  Reader in(source);
  if (!in.object(*root, "")) return tl::unexpected(in.error());
  std::vector<core::CameraKey> keys = read_keys(in, *root);
  const double near = in.number(*root, "", "near"), far = in.number(*root, "", "far", core::kInfiniteFar);
  if (in.ok() && !(near > 0.0)) in.complain("/near", "a number greater than 0", Reader::find(*root, "near"));
  if (in.ok() && !(far > near)) in.complain("/far", "a number greater than /near", Reader::find(*root, "far"));
  if (!in.ok()) return tl::unexpected(in.error());
  Expected<core::CameraPath> path = core::CameraPath::create(std::move(keys));
  if (!path) return fail(std::string(source) + ": /keys: " + path.error().message);
  path->near = near;
  path->far = far;
  return path;
}

Expected<core::CameraPath> read_path(const std::filesystem::path& file) {
  const Expected<std::string> text = slurp(file);
  if (!text) return tl::unexpected(text.error());
  return parse_path(*text, file.string());
}

std::string format_path(const core::CameraPath& path) {
  Json root = {{"keys", Json::array()}, {"near", path.near}};
  if (std::isfinite(path.far)) root["far"] = path.far;
  for (const core::CameraKey& key : path.keys())
    root["keys"].push_back({{"t", key.time},
                            {"eye", triple(key.pose.eye)},
                            {"target", triple(key.pose.target)},
                            {"up", triple(key.pose.up)},
                            {"fovy_deg", key.fovy / kDegrees}});
  return json::sorted(std::move(root)).dump(1) + "\n";
}

Expected<void> write_path(const std::filesystem::path& file, const core::CameraPath& path) {
  const std::string text = format_path(path);
  return core::write_file(file, {std::as_bytes(std::span(text))});
}

Expected<core::View> translated(const core::View& view, const dvec3& offset) {
  dmat4 eye_from_world = view.eye_from_world();
  for (int axis = 0; axis < 3; ++axis) eye_from_world[3] -= eye_from_world[axis] * offset[axis];
  Expected<core::View> moved = core::View::from_matrices(eye_from_world, view.clip_from_eye(), view.clip_depth());
  if (!moved) return moved;
  moved->sections = view.sections;
  for (core::Plane& plane : moved->sections) plane.offset -= glm::dot(plane.normal, offset);
  moved->section_mode = view.section_mode;
  moved->layers = view.layers;
  return moved;
}

Expected<core::CameraPath> translated(const core::CameraPath& path, const dvec3& offset) {
  std::vector<core::CameraKey> keys = path.keys();
  for (core::CameraKey& key : keys) {
    key.pose.eye += offset;
    key.pose.target += offset;
  }
  Expected<core::CameraPath> moved = core::CameraPath::create(std::move(keys));
  if (!moved) return moved;
  moved->near = path.near;
  moved->far = path.far;
  return moved;
}

}  // namespace sightline::importers
