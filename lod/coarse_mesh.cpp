#include "sightline/lod/coarse_mesh.h"

#include <cmath>

namespace sightline::lod {
namespace {

/// Groups of infinite error are never drawn simplified.
bool is_drawn_simplified(const MeshLevels& levels, std::uint32_t group) {
  return group != core::kNone && std::isfinite(levels.groups[group].error);
}

/// Keeps the vertices that triangles use.
class Vertices {
 public:
  explicit Vertices(const core::Mesh& mesh) : from_(mesh), number_of_(mesh.positions.size(), core::kNone) {}

  void add(std::uint32_t corner, core::Mesh& to) {
    std::uint32_t& number = number_of_[corner];
    if (number == core::kNone) {
      number = std::uint32_t(to.positions.size());
      to.positions.push_back(from_.positions[corner]);
      if (!from_.normals.empty()) to.normals.push_back(from_.normals[corner]);
    }
    to.indices.push_back(number);
  }

 private:
  const core::Mesh& from_;
  std::vector<std::uint32_t> number_of_;  // by vertex: its number in the coarse mesh
};

}  // namespace

CoarseMesh coarsest(const core::Mesh& mesh, const MeshLevels& levels) {
  CoarseMesh coarse;
  Vertices vertices(mesh);
  std::uint32_t group = core::kNone;  // clusters that one group has made follow each other
  for (const Cluster& cluster : levels.clusters) {
    if (is_drawn_simplified(levels, cluster.goes_into)) continue;
    if (cluster.made_by != core::kNone && !is_drawn_simplified(levels, cluster.made_by)) continue;
    for (std::uint32_t i = 0; i < cluster.index_count; ++i)
      vertices.add(levels.indices[cluster.first_index + i], coarse.mesh);
    if (cluster.made_by == core::kNone || cluster.made_by == group) continue;
    group = cluster.made_by;
    coarse.deviations.push_back({levels.groups[group].box, levels.groups[group].error});
  }
  return coarse;
}

}  // namespace sightline::lod
