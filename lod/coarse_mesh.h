// A coarser level of a mesh as a mesh of its own: for scenes that do not fit into memory, and for writers.
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

/// The coarsest level of which each group's error is at most `error`, in the mesh's own coordinates. Its deviations'
/// errors are at most that, too. 0: the mesh's triangles. `levels`: of the mesh, not empty.
SIGHTLINE_API CoarseMesh coarse_within(const core::Mesh& mesh, const MeshLevels& levels, float error);

/// What is drawn where a view allows every error that a mesh has a bound of: the triangles that no group simplifies, in
/// the order in which a cut draws them. `levels`: of the mesh, not empty.
SIGHTLINE_API CoarseMesh coarsest(const core::Mesh& mesh, const MeshLevels& levels);

}  // namespace sightline::lod
