// Surfaces of faces of meshes (core/mesh_extras.h) in a scene cache. Internal to the importers.
#pragma once

#include <memory>
#include <vector>

#include "sightline/core/mesh_extras.h"
#include "sightline/core/scene.h"
#include "sightline/importers/slc/internal/slc_file.h"

namespace sightline::importers {

/// Writes nothing where no mesh came with surfaces.
void write_surfaces(const core::Scene& scene, SlcWriter& out);

using SlcSurfaces = std::shared_ptr<const std::vector<core::MeshSurface>>;

/// By number of a mesh, below `mesh_count`; null for meshes without. Empty where the file has none.
SlcExpected<std::vector<SlcSurfaces>> read_surfaces(const SlcFile& file, const SlcFile::Mapping& mapping,
                                                    std::size_t mesh_count);

}  // namespace sightline::importers
