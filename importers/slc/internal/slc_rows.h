// Records of a scene cache for what the scene keeps otherwise than in flat arrays. Internal to the importers.
#pragma once

#include <cstdint>
#include <string>

#include <nlohmann/json.hpp>

#include "sightline/core/internal/storage.h"
#include "sightline/importers/import.h"

namespace sightline::importers {

struct SlcMaterial {
  float red, green, blue, alpha;
  std::uint32_t code, removed;
  std::uint64_t name_end;  // in the names of materials
};

/// The values of a mesh follow each other: positions, normals, indices, contour sizes, polygon contours.
struct SlcMesh {
  std::uint64_t name_end, first;  // in the names of meshes, in the values
  std::uint32_t positions, normals, indices, contours, polygons, removed;
};

struct SlcSnapshotState {
  double origin[3];
  float extent[6];
  double chunk_size;
};

/// As text, without the nodes. Bytes that are no UTF-8 are replaced.
std::string to_text(const ImportReport& report);
/// Fails, as null, on a text that is no report.
core::Expected<ImportReport> report_from(std::string_view text);

inline std::string to_text(const nlohmann::json& json) {
  return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace sightline::importers
