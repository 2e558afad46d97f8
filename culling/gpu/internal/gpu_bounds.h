// Item boxes of one batch in GPU memory, and those of its clusters of 64 consecutive records.
#pragma once

#include <span>
#include <vector>

#include "sightline/core/snapshot.h"
#include "sightline/culling/frustum/frustum_test.h"
#include "sightline/culling/occlusion/sample_test.h"
#include "sightline/gl/internal/buffer.h"
#include "sightline/gpuscene/internal/gpu_scene.h"

namespace sightline::culling {

using uint = std::uint32_t;  // as GLSL has it
#include "sightline/culling/gpu/shaders/cull_limits.glsl"
static_assert(kMaxPlanes == kMaxCullPlanes && kMaxSections == int(core::kMaxSectionPlanes));

/// Boxes of the records of a gpuscene::Batch: box k is that of record k. Entries without a record and vacant slots are
/// never visible.
class GpuBounds {
 public:
  /// `slots`: the slots of the batch's records, in order.
  static core::Expected<GpuBounds> create(const gl::Functions& gl, const core::Snapshot& snapshot,
                                          const gpuscene::Batch& batch, std::vector<core::Slot> slots);

  /// Adds the record of an appended slot; update() must follow with it. The batch has room: see GpuScene::append.
  std::uint32_t append(core::Slot slot);
  /// Rewrites the boxes of these records and of their clusters. `changed` is sorted. Slots with a bit in `left_out` are
  /// as vacant.
  void update(const core::Snapshot& snapshot, std::span<const std::uint32_t> changed, gpuscene::ElementWriter& writer,
              SlotBits left_out = {});
  /// Follows edits that move nothing, but make slots vacant or left out, or no longer so. Faster, since
  /// the boxes of clusters only grow, which is conservative.
  void update_shown(const core::Snapshot& snapshot, std::span<const std::uint32_t> changed,
                    gpuscene::ElementWriter& writer, SlotBits left_out);

  std::uint32_t cluster_count() const {
    return std::uint32_t((slots_.size() + kItemsPerCluster - 1) / kItemsPerCluster);
  }
  std::uint32_t cluster_capacity() const { return cluster_capacity_; }
  const std::vector<core::Slot>& slots() const { return slots_; }  ///< by record
  /// Two RGB32F texels per box: its least and its greatest corner. Entries without an item hold the inverted box.
  const gl::TexelArray& cluster_boxes() const { return cluster_boxes_; }
  const gl::TexelArray& item_boxes() const { return item_boxes_; }
  /// R32UI; none when the scene uses no layers.
  const gl::TexelArray& cluster_layers() const { return cluster_layers_; }
  const gl::TexelArray& item_layers() const { return item_layers_; }
  std::size_t memory_bytes() const {
    return item_boxes_.buffer.size() + item_layers_.buffer.size() + cluster_boxes_.buffer.size() +
           cluster_layers_.buffer.size();
  }

 private:
  using Clusters = std::span<const std::uint32_t>;  // in rising order
  void write(const core::Snapshot& snapshot, Clusters clusters, gpuscene::ElementWriter& writer, SlotBits left_out);
  void write_part(const core::Snapshot& snapshot, Clusters clusters, gpuscene::ElementWriter& writer,
                  SlotBits left_out);
  void write_clusters(Clusters clusters, gpuscene::ElementWriter& writer) const;

  std::vector<core::Slot> slots_;
  std::vector<core::Aabb> around_;            // by cluster, as on the GPU
  std::vector<std::uint32_t> layers_around_;  // by cluster; empty when the scene uses no layers
  std::uint32_t cluster_capacity_ = 0;
  gl::TexelArray item_boxes_, item_layers_, cluster_boxes_, cluster_layers_;
};

}  // namespace sightline::culling
