#include "sightline/lod/coarse_mesh.h"

#include <cmath>
#include <limits>

#include "sightline/lod/internal/part_of_mesh.h"

namespace sightline::lod {
namespace {

/// Groups of infinite error are never drawn simplified.
bool is_drawn_simplified(const MeshLevels& levels, std::uint32_t group, float most) {
  return group != core::kNone && std::isfinite(levels.groups[group].error) && levels.groups[group].error <= most;
}

}  // namespace

CoarseMesh coarse_within(const core::Mesh& mesh, const MeshLevels& levels, float error) {
  CoarseMesh coarse;
  PartOfMesh vertices(mesh);
  std::uint32_t group = core::kNone;  // clusters that one group has made follow each other
  for (const Cluster& cluster : levels.clusters) {
    if (is_drawn_simplified(levels, cluster.goes_into, error)) continue;
    if (cluster.made_by != core::kNone && !is_drawn_simplified(levels, cluster.made_by, error)) continue;
    for (std::uint32_t i = 0; i < cluster.index_count; ++i)
      vertices.add(levels.indices[cluster.first_index + i], coarse.mesh);
    if (cluster.made_by == core::kNone || cluster.made_by == group) continue;
    group = cluster.made_by;
    coarse.deviations.push_back({levels.groups[group].box, levels.groups[group].error});
  }
  return coarse;
}

CoarseMesh coarsest(const core::Mesh& mesh, const MeshLevels& levels) {
  return coarse_within(mesh, levels, std::numeric_limits<float>::max());
}

}  // namespace sightline::lod
