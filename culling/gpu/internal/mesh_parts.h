// Parts of meshes in GPU memory: the clusters of their levels (lod/mesh_levels.h), which are tested and drawn one by
// one. Internal to culling/gpu.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "sightline/core/snapshot.h"
#include "sightline/culling/gpu/internal/gpu_bounds.h"
#include "sightline/gpuscene/internal/free_space.h"
#include "sightline/gpuscene/internal/gpu_scene.h"
#include "sightline/lod/mesh_levels.h"

namespace sightline::culling {

/// Has the parts of each record whose mesh has levels: all clusters, of all levels. Each decides for itself whether a
/// view draws it, by the group that has made it and the one that it goes into. That is a cut: lod/internal/cut.h.
///
/// Parts of a record follow one another. Clusters of kItemsPerCluster consecutive parts are tested first, as clusters
/// of records are. What records share is in memory once. Shaders: part_data.glsl.
class MeshParts {
 public:
  /// `most`: number of parts; meshes that have no room are left to be drawn whole.
  explicit MeshParts(std::size_t most) : most_clusters_(std::uint32_t(most / kItemsPerCluster)) {}

  /// Whether update() would change what a record is drawn by.
  bool differs(const gpuscene::MeshPool& pool, std::uint32_t record) const;
  /// Follows records that are new, given up or have moved, or whose meshes have got levels or another place. `slots`:
  /// of all records. Fails when the GPU has too little memory.
  core::Expected<void> update(const gl::Functions& gl, const core::Snapshot& snapshot, const gpuscene::MeshPool& pool,
                              std::span<const std::uint32_t> records, std::span<const core::Slot> slots,
                              gpuscene::ElementWriter& writer);

  /// Whether the record is drawn by parts.
  bool has(std::uint32_t record) const { return instance_of(record) != core::kNone; }
  std::uint32_t cluster_count() const { return (space_.end() + kItemsPerCluster - 1) / kItemsPerCluster; }
  std::uint32_t cluster_capacity() const { return std::uint32_t(clusters_.buffer.size() / sizeof(Cluster)); }
  std::size_t capacity() const { return std::size_t(cluster_capacity()) * kItemsPerCluster; }  ///< parts
  const gl::TexelArray& clusters() const { return clusters_; }
  const gl::TexelArray& details() const { return details_; }
  std::size_t memory_bytes() const {
    return clusters_.buffer.size() + details_.buffer.size() + unoccluded_frames.size();
  }

  gl::Buffer unoccluded_frames;  ///< by part: see CullBatch
  /// Whether all in the view volume are drawn in the first pass of a frame: for section planes. Their caps need the
  /// whole mesh behind a cut face, also what is hidden.
  bool exempt = false;

 private:
  using Texel = std::array<std::uint32_t, 4>;
  /// As in part_data.glsl.
  struct Cluster {
    core::Aabb box;                        // in world coordinates, as those of items
    core::Aabb replacing;                  // of the groups that all parts go into
    float error;                           // the largest of these groups, and a little more
    std::uint32_t instance = core::kNone;  // whose parts all are
    std::uint32_t unused[2];
    std::array<std::array<std::uint32_t, 2>, kItemsPerCluster> parts;  // details of an instance, and of a cluster
  };
  static_assert(sizeof(Cluster) == kPartClusterTexels * sizeof(Texel));
  struct Part {
    std::uint32_t instance = core::kNone, cluster = 0;
  };
  struct Instance {
    std::uint32_t record, mesh, details, first_part;
  };
  struct Mesh {
    std::shared_ptr<const lod::MeshLevels> levels;
    std::uint32_t details, users;
    std::uint32_t first_index;  // as the commands of its records have them
    std::int32_t base_vertex;
  };

  std::uint32_t instance_of(std::uint32_t record) const {
    return record < instance_of_record_.size() ? instance_of_record_[record] : core::kNone;
  }
  void add(std::uint32_t record, std::shared_ptr<const lod::MeshLevels> levels,
           const gpuscene::ElementsCommand& command);
  void place(const core::Snapshot& snapshot, std::uint32_t instance, core::Slot slot);
  void release(std::uint32_t instance);
  std::uint32_t mesh_of(std::shared_ptr<const lod::MeshLevels> levels, const gpuscene::ElementsCommand& command);
  void write_mesh(const Mesh& mesh);
  void write(std::uint32_t place, const Texel& texel) { detail_writes_.emplace_back(place, texel); }
  void mark(const Instance& instance);
  Cluster make_cluster(const core::Snapshot& snapshot, std::uint32_t cluster, std::span<const core::Slot> slots) const;
  core::Expected<void> flush(const gl::Functions& gl, const core::Snapshot& snapshot, std::span<const core::Slot> slots,
                             gpuscene::ElementWriter& writer);

  std::uint32_t most_clusters_;
  std::vector<std::uint32_t> instance_of_record_;
  std::vector<Instance> instances_;
  std::vector<Mesh> meshes_;
  std::vector<std::uint32_t> unused_instances_, unused_meshes_;
  std::unordered_map<const lod::MeshLevels*, std::uint32_t> mesh_of_levels_;
  std::vector<Part> parts_;
  gpuscene::FreeSpace space_, detail_space_;  // of parts; of texels
  gl::TexelArray clusters_, details_;
  std::vector<std::uint32_t> changed_;                          // clusters
  std::vector<std::pair<std::uint32_t, Texel>> detail_writes_;  // place, texel
};

}  // namespace sightline::culling
