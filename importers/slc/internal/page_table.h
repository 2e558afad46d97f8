// What a scene cache says of its pages (core/paged_scene.h). Internal to the importers.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/snapshot.h"
#include "sightline/gpuprims/internal/joints.h"
#include "sightline/importers/slc/internal/slc_levels.h"
#include "sightline/importers/slc/internal/slc_rows.h"

namespace sightline::importers {

struct PageTable {
  std::vector<std::array<float, 6>> boxes;  ///< of leaves, relative to the origin of the snapshot's bounds
  std::vector<std::uint32_t> colours;       ///< of leaves: core::PagedScene::colours
  std::vector<std::uint64_t> ends;          ///< of leaves: two bits per slot, gpuprims::Ends that are hidden
  std::vector<SlcPage> pages;
};

/// `meshes`: the rows of the scene's meshes as they are written.
PageTable make_page_table(const core::Scene& scene, const core::Snapshot& snapshot,
                          const gpuprims::StoredJoints& joints, std::span<const SlcMesh> meshes);

/// Coarse forms of the pages, in which each mesh is the coarsest of its levels, as far as that halves the bytes of
/// their meshes. `meshes`: as above.
std::vector<SlcCoarsePage> coarse_pages(const core::Scene& scene, const core::Snapshot& snapshot,
                                        const PageTable& table, std::span<const SlcMesh> meshes,
                                        const CoarseMeshes& coarse);

/// Bytes of a mesh's values.
std::uint64_t value_bytes(const SlcMesh& mesh);
std::uint64_t value_bytes(const SlcCoarseMesh& mesh);

}  // namespace sightline::importers
