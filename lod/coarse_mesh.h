// The coarsest level of a mesh as a mesh of its own, for scenes that do not fit into memory.
#pragma once

#include <vector>

#include "sightline/core/mesh.h"
#include "sightline/core/paged_scene.h"
#include "sightline/lod/mesh_levels.h"

namespace sightline::lod {

struct CoarseMesh {
  core::Mesh mesh;  ///< the vertices that its triangles use, in their order; without name and polygons
  /// Where it is not the mesh itself. In the coordinates of both.
  std::vector<core::MeshDeviation> deviations;
};

/// What is drawn where a view allows every error that a mesh has a bound of: the triangles that no group simplifies, in
/// the order in which a cut draws them. `levels`: of the mesh, not empty.
SIGHTLINE_API CoarseMesh coarsest(const core::Mesh& mesh, const MeshLevels& levels);

}  // namespace sightline::lod
