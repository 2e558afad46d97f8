// Item boxes of one batch in GPU memory, and those of its clusters of 64 consecutive records.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "sightline/core/snapshot.h"
#include "sightline/culling/gpu/gpu_culler_config.h"
#include "sightline/gl/buffer.h"
#include "sightline/gpuscene/gpu_scene.h"

namespace sightline::culling {

inline constexpr std::uint32_t kClusterSize = 64;

/// What shaders read through a buffer texture, and the CPU may write.
struct TexelArray {
  gl::Buffer buffer;
  gl::TextureBuffer texels;

  /// `data`: copied, or null for undefined contents.
  static core::Expected<TexelArray> create(const gl::Functions& gl, std::size_t bytes, const void* data, GLenum format,
                                           const char* what);
};

/// Follows the records of a gpuscene::Batch: place k is record k. Nothing is visible of places without a record and of
/// vacant slots.
class GpuBounds {
 public:
  /// What `form` becomes for a batch: meshes and lines have no shape in their records.
  static GpuBoundsForm form_for(gpuscene::BatchKind kind, GpuBoundsForm form);

  /// `slots`: of the batch's records, in order. `form`: one that form_for() returns.
  static core::Expected<GpuBounds> create(const gl::Functions& gl, const core::Snapshot& snapshot,
                                          const gpuscene::Batch& batch, std::vector<core::Slot> slots,
                                          GpuBoundsForm form);

  /// Adds the record of an appended slot; update() must follow with it. The batch has room: see GpuScene::append.
  std::uint32_t append(core::Slot slot);
  /// Writes the boxes of these records anew, and those of their clusters. `changed` is sorted.
  void update(const core::Snapshot& snapshot, std::span<const std::uint32_t> changed,
              gpuscene::ElementWriter& writer) const;

  GpuBoundsForm form() const { return form_; }
  std::uint32_t cluster_count() const { return std::uint32_t((slots_.size() + kClusterSize - 1) / kClusterSize); }
  std::uint32_t cluster_capacity() const { return cluster_capacity_; }
  const std::vector<core::Slot>& slots() const { return slots_; }  ///< by record
  /// Two RGB32F texels each, min and max, as core::Aabb; R32UI, none when the scene uses no layers.
  const TexelArray& cluster_boxes() const { return cluster_boxes_; }
  const TexelArray& cluster_layers() const { return cluster_layers_; }
  /// The same of items, or one RG32UI texel with a CompactBox each, or of a cluster's items one RGBA32UI texel with two
  /// bits each: it is there, and its record gives a box around that of core. Where it does not, the cluster's box
  /// counts.
  const TexelArray& item_boxes() const { return item_boxes_; }
  const TexelArray& item_layers() const { return item_layers_; }
  std::size_t memory_bytes() const {
    return item_boxes_.buffer.size() + item_layers_.buffer.size() + cluster_boxes_.buffer.size() +
           cluster_layers_.buffer.size();
  }

 private:
  using Clusters = std::span<const std::uint32_t>;  // in rising order
  void write(const core::Snapshot& snapshot, Clusters clusters, gpuscene::ElementWriter& writer) const;
  void write_part(const core::Snapshot& snapshot, Clusters clusters, gpuscene::ElementWriter& writer) const;
  void write_items(const core::Snapshot& snapshot, Clusters clusters, std::span<const core::Aabb> boxes,
                   std::span<const core::Aabb> around, gpuscene::ElementWriter& writer) const;

  std::vector<core::Slot> slots_;
  gpuscene::BatchKind kind_ = gpuscene::BatchKind::kMesh;
  GpuBoundsForm form_ = GpuBoundsForm::kFloat;
  int texels_per_item_ = 0;
  std::uint32_t cluster_capacity_ = 0;
  TexelArray item_boxes_, item_layers_, cluster_boxes_, cluster_layers_;
};

/// Origin of a chunk as shaders see it, relative to that of the boxes.
core::vec3 chunk_place(const core::Snapshot& snapshot, std::uint32_t chunk);

}  // namespace sightline::culling
