// lod: triangles of a mesh in clusters, and coarser levels of them with a proven error.
//
// The triangles of a mesh are divided into clusters, which are culled as items are. Groups of neighbouring clusters are
// simplified together, and what comes out is divided into clusters of the next level, and so on. Vertices between
// groups stay where they are. So any cut through this hierarchy (each group either simplified or not, with all groups
// below it simplified that a simplified one was made of) shows the mesh without cracks. (F. Ponchio, "Multiresolution
// structures for interactive visualization of very large 3D datasets", 2008; B. Karis, R. Stubbe, G. Wihlidal, "Nanite:
// A deep dive", 2021.) Theirs is an estimate of the error. Here each group has a bound that is proved:
// surface_deviation.h. Of many loose parts in a group, such as bars of a grating, some may be left out: each lies within
// that bound of what stays, as the surface that stays lies within it of the original.
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

#include "sightline/core/aabb.h"
#include "sightline/core/api.h"
#include "sightline/core/mesh.h"

namespace sightline::lod {

/// Triangles per cluster, at most.
inline constexpr std::uint32_t kClusterTriangles = 128;
/// Meshes of so many triangles are worth clusters even where they are drawn in full: parts of them lie outside a view.
inline constexpr std::size_t kLargeMesh = 16'384;
inline bool is_large(const core::Mesh& mesh) {
  return mesh.indices.size() >= 3 * kLargeMesh;
}

/// Triangles that are drawn together, or left out together.
struct Cluster {
  std::uint32_t first_index = 0, index_count = 0;  ///< in MeshLevels::indices
  std::uint32_t made_by = core::kNone;             ///< group that this cluster simplifies; kNone: of the mesh itself
  std::uint32_t goes_into = core::kNone;           ///< group that simplifies this cluster; kNone: none does
  core::Aabb box;                                  ///< of the triangles
};

/// Clusters that are simplified together. Its error and box are at least those of the groups that its clusters were
/// made by. A group of infinite error only holds many clusters together, by a box: it has made one cluster without
/// triangles.
struct ClusterGroup {
  /// Each point of the simplified surface has a point of the original within so many metres (of the mesh's own
  /// coordinates), and the other way round. Proved, and rounded up.
  float error = 0.0f;
  /// The normals of the two points differ by at most so many radians, where both triangles have one.
  float angle = 0.0f;
  core::Aabb box;                                    ///< holds both surfaces
  std::uint32_t first_member = 0, member_count = 0;  ///< in MeshLevels::members
};

/// A mesh in clusters of several levels. Immutable once built; time and place of building do not show.
struct MeshLevels {
  std::vector<std::uint32_t> indices;  ///< of the mesh's vertices, three per triangle
  std::vector<Cluster> clusters;       ///< level by level from the finest; indices lie in the same order
  std::vector<ClusterGroup> groups;    ///< level by level
  std::vector<std::uint32_t> members;  ///< clusters of each group; then those that go into none, from first_root on
  std::uint32_t first_root = 0;
  std::uint32_t mesh_clusters = 0;  ///< number of first clusters, which hold all triangles of the mesh
  /// Number of first indices that belong to solid shells (internal/solid_shells.h), in clusters of their own.
  std::uint32_t solid_indices = 0;

  bool empty() const { return clusters.empty(); }
  std::size_t memory_bytes() const {
    return indices.size() * sizeof(std::uint32_t) + clusters.size() * sizeof(Cluster) +
           groups.size() * sizeof(ClusterGroup) + members.size() * sizeof(std::uint32_t);
  }
};

/// Whether a mesh gains by levels: it has more than a few dozen triangles.
SIGHTLINE_API bool needs_levels(const core::Mesh& mesh);

/// Divides a mesh, which passes validate(), into clusters alone; there are no coarser levels. About 0.5 us a triangle.
/// `stop`: the result may then be without any.
SIGHTLINE_API MeshLevels build_clusters(const core::Mesh& mesh, int threads = 0, const std::stop_token& stop = {});

/// Divides a mesh, which passes validate(), into clusters, and makes its levels. The first clusters hold the same
/// triangles as the mesh, by vertices of the same positions and normals. Levels end where simplification does, or at
/// a few dozen triangles. Without any for meshes that need none or have coordinates that are not finite. The
/// result does not depend on the number of threads (OpenMP; 0: all that it offers). Takes about 3 us a triangle. `stop`
/// ends that within a fraction of the time of the clusters, and the result is then without any.
SIGHTLINE_API MeshLevels build_levels(const core::Mesh& mesh, int threads = 0, const std::stop_token& stop = {});

}  // namespace sightline::lod
