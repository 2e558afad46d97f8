#include "sightline/apps/viewpoints/markup.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "sightline/apps/viewpoints/point_json.h"

namespace sightline::apps {
namespace {

using Json = json::Value;
using Stroke = std::vector<core::dvec3>;

constexpr double kHeadLength = 0.22, kHeadWidth = 0.09;  // of an arrow's length; the width to either side
constexpr int kBowsAround = 24, kBowSegments = 6;        // of a cloud

std::vector<Stroke> arrow_strokes(const core::dvec3& from, const core::dvec3& tip, const core::dvec3& ahead) {
  std::vector<Stroke> all{{from, tip}};
  const core::dvec3 along = tip - from, across = glm::cross(along, ahead);
  const double length = glm::length(along), wide = glm::length(across);
  if (!(wide > 0.0)) return all;
  const core::dvec3 foot = tip - kHeadLength * along, aside = across * (kHeadWidth * length / wide);
  all.push_back({foot + aside, tip, foot - aside});
  return all;
}

/// Half circles along an edge, away from the rectangle's middle, without the last point.
void add_bows(Stroke& stroke, const core::dvec3& a, const core::dvec3& b, const core::dvec3& outward, int bows) {
  const core::dvec3 step = (b - a) / double(bows);
  const double radius = 0.5 * glm::length(step), length = glm::length(outward);
  const core::dvec3 out = length > 0.0 ? outward * (radius / length) : core::dvec3(0.0);
  for (int bow = 0; bow < bows; ++bow)
    for (int i = 0; i < kBowSegments; ++i) {
      const double angle = std::numbers::pi * i / kBowSegments;
      stroke.push_back(a + step * (bow + 0.5 - 0.5 * std::cos(angle)) + out * std::sin(angle));
    }
}

Stroke cloud_stroke(const std::vector<core::dvec3>& corners) {
  const core::dvec3 middle = 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
  const double around = 2.0 * (glm::length(corners[1] - corners[0]) + glm::length(corners[2] - corners[1]));
  Stroke stroke;
  for (std::size_t i = 0; i < 4; ++i) {
    const core::dvec3 &a = corners[i], &b = corners[(i + 1) % 4];
    const double share = around > 0.0 ? glm::length(b - a) / around : 0.25;
    const int bows = std::max(1, int(std::lround(kBowsAround * std::min(share, 1.0))));
    add_bows(stroke, a, b, 0.5 * (a + b) - middle, bows);
  }
  stroke.push_back(corners[0]);
  return stroke;
}

/// Whether a mark-up of a kind can have so many points.
bool can_have(Markup::Kind kind, std::size_t points) {
  constexpr std::size_t kCounts[] = {2, 4, 1, 2};
  const std::size_t count = kCounts[std::size_t(kind)];
  return kind == Markup::Kind::kLine ? points >= count : points == count;
}

core::Expected<Markup> markup_of(const Json& json, const std::string& where) {
  const auto failed = [&](const std::string& why) { return core::fail(where + ": " + why); };
  if (!json.is_object() || !json.contains("kind") || !json["kind"].is_string() || !json.contains("points") ||
      !json["points"].is_array())
    return failed(R"(expected {"kind":"…", "points":[[X,Y,Z],…]})");
  const std::string kind = json["kind"].get<std::string>();
  const auto* const known = std::find(kMarkupKinds.begin(), kMarkupKinds.end(), kind);
  if (known == kMarkupKinds.end()) return failed("expected arrow, cloud, text or line, found \"" + kind + "\"");
  Markup markup{Markup::Kind(known - kMarkupKinds.begin()), {}, ""};
  const Json& points = json["points"];
  if (!std::all_of(points.begin(), points.end(), is_point) || !can_have(markup.kind, points.size()))
    return failed("expected points [X,Y,Z]: 2 of an arrow, 4 of a cloud, 1 of a text, 2 or more of a line");
  for (const Json& point : points) markup.points.push_back(point_of(point));
  if (!json.contains("words")) return markup;
  if (!json["words"].is_string())
    return failed(std::string("/words: expected a string, found ") + json["words"].type_name());
  markup.words = json["words"].get<std::string>();
  return markup;
}

}  // namespace

std::string_view name_of(Markup::Kind kind) {
  return kMarkupKinds[std::size_t(kind)];
}

std::vector<Stroke> strokes(const Markup& markup, const core::dvec3& ahead) {
  switch (markup.kind) {
    case Markup::Kind::kArrow:
      return arrow_strokes(markup.points[0], markup.points[1], ahead);
    case Markup::Kind::kCloud:
      return {cloud_stroke(markup.points)};
    case Markup::Kind::kLine:
      return {markup.points};
    case Markup::Kind::kText:
      break;
  }
  return {};
}

core::dvec3 words_place(const Markup& markup) {
  const std::vector<core::dvec3>& points = markup.points;
  return markup.kind == Markup::Kind::kCloud ? 0.5 * (points[0] + points[1]) : points[0];
}

Json to_json(const Markup& markup) {
  Json json{{"kind", std::string(name_of(markup.kind))}, {"points", Json::array()}};
  for (const core::dvec3& point : markup.points) json["points"].push_back(point_json(point));
  if (!markup.words.empty()) json["words"] = markup.words;
  return json;
}

core::Expected<std::vector<Markup>> markups_of(const Json& json, const std::string& where) {
  if (!json.is_array()) return core::fail(where + ": expected an array of mark-ups, found " + json.type_name());
  std::vector<Markup> list;
  for (std::size_t i = 0; i < json.size(); ++i) {
    auto markup = markup_of(json[i], where + "/" + std::to_string(i));
    if (!markup) return tl::unexpected(markup.error());
    list.push_back(std::move(*markup));
  }
  return list;
}

}  // namespace sightline::apps
