#include "sightline/apps/viewpoints/viewpoint.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>

#include "sightline/apps/viewpoints/point_json.h"
#include "sightline/core/internal/platform/clock.h"
#include "sightline/core/internal/platform/environment.h"
#include "sightline/importers/json/internal/json.h"
#include "sightline/importers/view_json.h"

namespace sightline::apps {
namespace {

using Json = json::Value;

constexpr int kMaxDepth = 66;  // a view's reader allows 64, here below a list and its object

struct TextKey {
  const char* key;
  std::string Viewpoint::*text;
};
constexpr TextKey kTexts[] = {{"name", &Viewpoint::name},     {"comment", &Viewpoint::comment},
                              {"author", &Viewpoint::author}, {"date", &Viewpoint::date},
                              {"guid", &Viewpoint::guid},     {"status", &Viewpoint::status},
                              {"type", &Viewpoint::type}};
struct PartsKey {
  const char* key;
  PartSet Viewpoint::Shown::*parts;
};
constexpr PartsKey kParts[] = {{"hidden", &Viewpoint::Shown::hidden},
                               {"ghosts", &Viewpoint::Shown::ghosts},
                               {"selection", &Viewpoint::Shown::selection}};

double distance(const core::Pose& pose) {
  return glm::length(pose.target - pose.eye);
}

Json to_json(const PartSet& set) {
  Json names = Json::array();
  for (const PartName& part : set.parts) names.push_back(to_text(part));
  return set.all_but ? Json{{"all_but", std::move(names)}} : names;
}

Json to_json(const Viewpoint& viewpoint) {
  const core::Pose& pose = viewpoint.pose;
  Json json{{"eye", point_json(pose.eye)}, {"target", point_json(pose.target)}, {"up", point_json(pose.up)}};
  if (viewpoint.orthographic)
    json["ortho_height"] = 2.0 * distance(pose) * std::tan(0.5 * viewpoint.fovy);
  else
    json["fovy_deg"] = glm::degrees(viewpoint.fovy);
  // Other tools need a near plane: where none is known, one that cuts nothing which is looked at.
  json["near"] = viewpoint.near > 0.0 || viewpoint.orthographic ? viewpoint.near : 1e-3 * distance(pose);
  for (const core::Plane& plane : viewpoint.sections)
    json["sections"].push_back({{"n", point_json(plane.normal)}, {"d", plane.offset}});
  for (const Measurement& one : viewpoint.measurements)
    json["measurements"].push_back({{"from", point_json(one.from)}, {"to", point_json(one.to)}, {"words", one.words}});
  for (const Markup& one : viewpoint.markups) json["markups"].push_back(to_json(one));
  for (const auto& [key, text] : kTexts)
    if (!(viewpoint.*text).empty()) json[key] = viewpoint.*text;
  if (viewpoint.colour_by) json["colour_by"] = *viewpoint.colour_by;
  if (viewpoint.shown)
    for (const auto& [key, parts] : kParts) json[key] = to_json((*viewpoint.shown).*parts);
  return json;
}

/// Names of files and nodes need not be UTF-8.
std::string text_of(const Json& json) {
  return json.dump(1) + "\n";
}

core::Expected<PartSet> parts_of(const Json& json, const std::string& where) {
  PartSet set{json.is_object() && json.contains("all_but"), {}};
  const Json& names = set.all_but ? json["all_but"] : json;
  if (!names.is_array() || !std::all_of(names.begin(), names.end(), [](const Json& name) { return name.is_string(); }))
    return core::fail(where + ": expected an array of names, or {\"all_but\":[names]}, found " +
                      std::string(names.type_name()));
  for (const Json& name : names) set.parts.push_back(part_of(name.get<std::string>()));
  return set;
}

core::Expected<std::vector<Measurement>> measurements_of(const Json& json, const std::string& where) {
  const auto has_point = [](const Json& one, const char* key) {
    return one.is_object() && one.contains(key) && is_point(one[key]);
  };
  std::vector<Measurement> list;
  for (const Json& one : json.is_array() ? json : Json::array({json})) {
    if (!has_point(one, "from") || !has_point(one, "to"))
      return core::fail(where + ": expected an array of {\"from\":[X,Y,Z], \"to\":[X,Y,Z]}");
    list.push_back({point_of(one["from"]), point_of(one["to"]), ""});
    if (one.contains("words") && one["words"].is_string()) list.back().words = one["words"].get<std::string>();
  }
  return list;
}

/// The camera of a view whose keys are known to be right.
Viewpoint camera_of(const Json& json) {
  Viewpoint viewpoint;
  viewpoint.pose.eye = point_of(json["eye"]);
  viewpoint.pose.target = point_of(json["target"]);
  if (json.contains("up")) viewpoint.pose.up = point_of(json["up"]);
  viewpoint.orthographic = json.contains("ortho_height");
  viewpoint.fovy = viewpoint.orthographic
                       ? 2.0 * std::atan(0.5 * json["ortho_height"].get<double>() / distance(viewpoint.pose))
                       : glm::radians(json["fovy_deg"].get<double>());
  viewpoint.near = json["near"].get<double>();
  if (json.contains("sections"))
    for (const Json& section : json["sections"])
      viewpoint.sections.push_back({point_of(section["n"]), section["d"].get<double>()});
  return viewpoint;
}

core::Expected<Viewpoint> viewpoint_of(const Json& json, const std::string& text, const std::string& source) {
  // What is wrong with a file is said by its reader; after that the keys of a camera are as they should be.
  if (const auto view = importers::parse_view(text, 1.0, source); !view) return tl::unexpected(view.error());
  Viewpoint viewpoint = camera_of(json);
  const auto take = [&](const char* key, auto& value) -> core::Expected<void> {
    if (!json.contains(key)) return {};
    if (!json[key].is_string())
      return core::fail(source + ": /" + key + ": expected a string, found " + json[key].type_name());
    value = json[key].get<std::string>();
    return {};
  };
  for (const auto& [key, member] : kTexts)
    if (auto done = take(key, viewpoint.*member); !done) return tl::unexpected(done.error());
  if (auto done = take("colour_by", viewpoint.colour_by); !done) return tl::unexpected(done.error());
  if (json.contains("measurements")) {
    auto list = measurements_of(json["measurements"], source + ": /measurements");
    if (!list) return tl::unexpected(list.error());
    viewpoint.measurements = std::move(*list);
  }
  if (json.contains("markups")) {
    auto list = markups_of(json["markups"], source + ": /markups");
    if (!list) return tl::unexpected(list.error());
    viewpoint.markups = std::move(*list);
  }
  for (const auto& [key, member] : kParts) {
    if (!json.contains(key)) continue;
    auto parts = parts_of(json[key], source + ": /" + key);
    if (!parts) return tl::unexpected(parts.error());
    if (!viewpoint.shown) viewpoint.shown.emplace();
    (*viewpoint.shown).*member = std::move(*parts);
  }
  return viewpoint;
}

}  // namespace

std::string format_viewpoint(const Viewpoint& viewpoint) {
  return text_of(to_json(viewpoint));
}

std::string format_viewpoints(std::span<const Viewpoint> viewpoints) {
  Json json = Json::object();
  if (!viewpoints.empty()) {
    Viewpoint first = viewpoints.front();
    for (const auto& [key, text] : kTexts) (first.*text).clear();
    first.shown.reset();
    first.measurements.clear();
    first.markups.clear();
    json = to_json(first);
  }
  json["views"] = Json::array();
  for (const Viewpoint& viewpoint : viewpoints) json["views"].push_back(to_json(viewpoint));
  return text_of(json);
}

core::Expected<std::vector<Viewpoint>> parse_viewpoints(const std::string& text, const std::string& source) {
  // What cannot be parsed is an error of the view's reader.
  const Json json = json::parse(text, {.max_depth = kMaxDepth}).value_or(Json());
  std::vector<Viewpoint> list;
  if (json.is_object() && json.contains("views")) {
    const Json& views = json["views"];
    if (!views.is_array())
      return core::fail(source + ": /views: expected an array of views, found " + views.type_name());
    for (std::size_t i = 0; i < views.size(); ++i) {
      auto viewpoint = viewpoint_of(views[i], text_of(views[i]), source + ": /views/" + std::to_string(i));
      if (!viewpoint) return tl::unexpected(viewpoint.error());
      list.push_back(std::move(*viewpoint));
    }
    return list;
  }
  auto viewpoint = viewpoint_of(json, text, source);
  if (!viewpoint) return tl::unexpected(viewpoint.error());
  list.push_back(std::move(*viewpoint));
  return list;
}

Viewpoint translated(const Viewpoint& viewpoint, const core::dvec3& offset) {
  Viewpoint moved = viewpoint;
  moved.pose.eye += offset;
  moved.pose.target += offset;
  for (Measurement& one : moved.measurements) {
    one.from += offset;
    one.to += offset;
  }
  for (Markup& one : moved.markups)
    for (core::dvec3& point : one.points) point += offset;
  for (core::Plane& plane : moved.sections) plane.offset -= glm::dot(plane.normal, offset);
  return moved;
}

std::string author_name() {
  for (const char* name : {"SIGHTLINE_AUTHOR", "USER", "USERNAME"})
    if (const auto value = core::platform::environment(name); value && !value->empty()) return *value;
  return "unknown";
}

std::string date_now() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  char text[32] = "";
  if (core::platform::utc_of(now, utc)) std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

}  // namespace sightline::apps
