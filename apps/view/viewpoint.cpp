#include "sightline/apps/view/viewpoint.h"

#include <cmath>
#include <fstream>
#include <sstream>

#include <nlohmann/json.hpp>

#include "sightline/importers/view_json.h"

namespace sightline::apps {
namespace {

using Json = nlohmann::ordered_json;

Json to_json(const core::dvec3& v) {
  return Json::array({v.x, v.y, v.z});
}

core::dvec3 vector_of(const Json& json) {
  return {json[0].get<double>(), json[1].get<double>(), json[2].get<double>()};
}

double distance(const core::Pose& pose) {
  return glm::length(pose.target - pose.eye);
}

}  // namespace

std::string format_viewpoint(const Viewpoint& viewpoint) {
  const core::Pose& pose = viewpoint.pose;
  Json json{{"eye", to_json(pose.eye)}, {"target", to_json(pose.target)}, {"up", to_json(pose.up)}};
  if (viewpoint.orthographic)
    json["ortho_height"] = 2.0 * distance(pose) * std::tan(0.5 * viewpoint.fovy);
  else
    json["fovy_deg"] = glm::degrees(viewpoint.fovy);
  json["near"] = viewpoint.near;
  for (const core::Plane& plane : viewpoint.sections)
    json["sections"].push_back({{"n", to_json(plane.normal)}, {"d", plane.offset}});
  return json.dump(1) + "\n";
}

core::Expected<Viewpoint> parse_viewpoint(const std::string& text, const std::string& source) {
  // What is wrong with a file is said by its reader; after that all keys are as they should be.
  if (const auto view = importers::parse_view(text, 1.0, source); !view) return tl::unexpected(view.error());
  const Json json = Json::parse(text);
  Viewpoint viewpoint;
  viewpoint.pose.eye = vector_of(json["eye"]);
  viewpoint.pose.target = vector_of(json["target"]);
  if (json.contains("up")) viewpoint.pose.up = vector_of(json["up"]);
  viewpoint.orthographic = json.contains("ortho_height");
  viewpoint.fovy = viewpoint.orthographic
                       ? 2.0 * std::atan(0.5 * json["ortho_height"].get<double>() / distance(viewpoint.pose))
                       : glm::radians(json["fovy_deg"].get<double>());
  viewpoint.near = json["near"].get<double>();
  if (json.contains("sections"))
    for (const Json& section : json["sections"])
      viewpoint.sections.push_back({vector_of(section["n"]), section["d"].get<double>()});
  return viewpoint;
}

core::Expected<Viewpoint> read_viewpoint(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) return core::fail(file.string() + ": cannot be read");
  std::ostringstream text;
  text << in.rdbuf();
  return parse_viewpoint(text.str(), file.string());
}

Viewpoint translated(const Viewpoint& viewpoint, const core::dvec3& offset) {
  Viewpoint moved = viewpoint;
  moved.pose.eye += offset;
  moved.pose.target += offset;
  for (core::Plane& plane : moved.sections) plane.offset -= glm::dot(plane.normal, offset);
  return moved;
}

}  // namespace sightline::apps
