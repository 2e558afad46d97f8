// Levels of detail of meshes in a scene cache. Internal to the importers.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "sightline/core/mesh_extras.h"
#include "sightline/core/scene.h"
#include "sightline/importers/slc/internal/slc_file.h"
#include "sightline/importers/slc/internal/slc_rows.h"
#include "sightline/lod/stored_levels.h"

namespace sightline::importers {

/// A mesh's levels as lod::encode() gives them. No bytes: it has none.
struct SlcLevels {
  std::uint64_t first, bytes, checksum;  // in the values of levels; of these bytes
};

/// Coarsest levels of meshes by number of the mesh, as they are written.
struct CoarseMeshes {
  std::vector<std::uint32_t> level_indices;  // of all levels
  std::vector<SlcCoarseMesh> rows;
  std::vector<std::byte> values;
};

/// Writes the arrays of levels: those that meshes came with, and where `build` others. `meshes`: numbers of meshes, in
/// the order in which they shall lie. Writes nothing where there are none to write and none were to be built. False
/// when `progress`, which takes the share that is done, has cancelled it. `coarse`: gets the coarsest of those written.
bool write_levels(const core::Scene& scene, std::span<const std::uint32_t> meshes, bool build,
                  const std::function<bool(double)>& progress, SlcWriter& out, CoarseMeshes& coarse);

/// Whether a file has levels that this build can use.
bool has_levels(const SlcFile& file, const SlcFile::Mapping& mapping);

/// By number of a mesh, below `mesh_count`: its levels, or null. They are read and compared with their checksums when
/// somebody asks for their bytes. Empty where the file has none that this build can use.
SlcExpected<std::vector<std::shared_ptr<const core::StoredBytes>>> read_levels(
    const std::shared_ptr<const SlcFile>& file, const SlcFile::Mapping& mapping, std::size_t mesh_count);

/// The levels of a mesh whose row says that it has some. `values`: the section in which they lie.
std::shared_ptr<const core::StoredBytes> levels_in_file(std::shared_ptr<const SlcFile> file,
                                                        const SlcFile::Section& values, const SlcLevels& row);

}  // namespace sightline::importers
