// The result of an import as JSON, with the same names in every tool (those of sightline-info --json).
#pragma once

#include <nlohmann/json.hpp>

#include "sightline/importers/import.h"

namespace sightline::apps {

inline nlohmann::json items_json(const std::array<std::uint64_t, core::kKindCount>& items) {
  nlohmann::json out;
  for (int k = 0; k < core::kKindCount; ++k) out[std::string(core::name_of(core::Kind(k)))] = items[std::size_t(k)];
  return out;
}

inline nlohmann::json warnings_json(const std::vector<importers::ImportWarning>& warnings) {
  nlohmann::json out = nlohmann::json::array();
  for (const auto& w : warnings) out.push_back({{"file", w.file}, {"offset", w.offset}, {"message", w.message}});
  return out;
}

inline nlohmann::json recognition_json(const importers::RecognitionReport& report) {
  nlohmann::json items, refused;
  for (int k = 0; k < core::kPrimitiveKindCount; ++k)
    items[std::string(core::name_of(core::Kind(k)))] = report.items[std::size_t(k)];
  for (std::size_t k = 0; k < importers::kRefusalCount; ++k)
    refused[std::string(name_of(importers::Refusal(k)))] = report.refused[k];
  return {{"meshes", report.meshes},
          {"items", items},
          {"triangles_before", report.triangles_before},
          {"triangles_after", report.triangles_after},
          {"bytes_before", report.bytes_before},
          {"bytes_after", report.bytes_after},
          {"largest_deviation", report.largest_deviation},
          {"refused", refused}};
}

}  // namespace sightline::apps
