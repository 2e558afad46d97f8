// Points as JSON, [X,Y,Z]. Internal to apps/viewpoints.
#pragma once

#include <algorithm>

#include "sightline/core/conventions.h"
#include "sightline/importers/json/internal/json.h"

namespace sightline::apps {

inline json::Value point_json(const core::dvec3& v) {
  return json::Value::array({v.x, v.y, v.z});
}
inline bool is_point(const json::Value& json) {
  return json.is_array() && json.size() == 3 &&
         std::all_of(json.begin(), json.end(), [](const json::Value& number) { return number.is_number(); });
}
/// The value must be one.
inline core::dvec3 point_of(const json::Value& json) {
  return {json[0].get<double>(), json[1].get<double>(), json[2].get<double>()};
}

}  // namespace sightline::apps
