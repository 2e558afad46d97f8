// The result of an import as JSON, with the same names in every tool (those of sightline-info --json), in ascending
// order.
#pragma once

#include "sightline/importers/import.h"
#include "sightline/importers/json/internal/json.h"

namespace sightline::apps {

inline json::Value items_json(const std::array<std::uint64_t, core::kKindCount>& items) {
  json::Value out;
  for (int k = 0; k < core::kKindCount; ++k) out[std::string(core::name_of(core::Kind(k)))] = items[std::size_t(k)];
  return json::sorted(std::move(out));
}

inline json::Value warnings_json(const std::vector<importers::ImportWarning>& warnings) {
  json::Value out = json::Value::array();
  for (const auto& w : warnings) out.push_back({{"file", w.file}, {"offset", w.offset}, {"message", w.message}});
  return json::sorted(std::move(out));
}

inline json::Value recognition_json(const importers::RecognitionReport& report) {
  json::Value items, refused;
  for (int k = 0; k < core::kPrimitiveKindCount; ++k)
    items[std::string(core::name_of(core::Kind(k)))] = report.items[std::size_t(k)];
  for (std::size_t k = 0; k < importers::kRefusalCount; ++k)
    refused[std::string(name_of(importers::Refusal(k)))] = report.refused[k];
  return json::sorted({{"meshes", report.meshes},
                       {"items", items},
                       {"triangles_before", report.triangles_before},
                       {"triangles_after", report.triangles_after},
                       {"bytes_before", report.bytes_before},
                       {"bytes_after", report.bytes_after},
                       {"largest_deviation", report.largest_deviation},
                       {"refused", refused}});
}

inline json::Value surfaces_json(const importers::ExactSurfaceReport& report) {
  return json::sorted({{"parts", report.parts},
                       {"instances", report.instances},
                       {"analytic_solids", report.analytic_solids},
                       {"meshed_bodies", report.meshed_bodies},
                       {"triangles", report.triangles},
                       {"failed_faces", report.failed_faces},
                       {"curves", report.curves},
                       {"annotations", report.annotations},
                       {"largest_tolerance", report.largest_tolerance},
                       {"deviation", report.deviation},
                       {"analytic_deviation", report.analytic_deviation}});
}

}  // namespace sightline::apps
