// Records of a scene cache for what the scene keeps otherwise than in flat arrays. Internal to the importers.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sightline/importers/import.h"
#include "sightline/importers/json/internal/json.h"
#include "sightline/importers/slc/internal/slc_file.h"
#include "sightline/importers/slc/internal/storage.h"

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
  double fitted[6];  // core::FittedBounds
  std::uint64_t outliers;
};

/// Slots that are read together (core/paged_scene.h). Pages follow each other; each begins at a multiple of kPageStep.
struct SlcPage {
  std::uint32_t first, count;                                                // slots
  std::uint32_t kind_first[core::kKindCount], kind_count[core::kKindCount];  // in the arrays by kind
  std::uint64_t mesh_positions, mesh_indices, mesh_bytes;                    // of all meshes that it uses, each once
  std::uint64_t checksum;                                                    // of slices() and these meshes
};
static_assert(sizeof(SlcPage) == 8 * (1 + core::kKindCount + 4));
inline constexpr std::uint32_t kPageStep = 64;

/// The coarsest level of a mesh. Its values follow each other: positions, normals, indices, deviations. Without
/// positions: the mesh has no other.
struct SlcCoarseMesh {
  std::uint64_t first;  // in the values of coarse meshes
  std::uint32_t positions, normals, indices, deviations;
};

/// What of a page is other where each mesh is the coarsest.
struct SlcCoarsePage {
  std::uint64_t mesh_positions, mesh_indices, mesh_bytes;  // as those of SlcPage; no bytes: there is no such page
  std::uint64_t deviations, level_indices;  // level_indices: of the page itself, whether there is this one
  std::uint64_t
      checksum;  // of slices(), and for each mesh of its row here and its values, or row and values of SlcMesh
};

/// Elements of an array that belong to a page.
struct SlcSlice {
  std::uint64_t number, first, count;
};
/// In the order in which they are summed up. `layers`: whether the snapshot has some.
std::vector<SlcSlice> slices(const SlcPage& page, bool layers);

/// As text, without the nodes. Bytes that are no UTF-8 are replaced.
std::string to_text(const ImportReport& report);
/// Fails, as null, on a text that is no report.
core::Expected<ImportReport> report_from(std::string_view text);

inline std::string to_text(json::Value json) {
  return json::sorted(std::move(json)).dump();
}

}  // namespace sightline::importers
