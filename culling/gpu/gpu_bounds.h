// Item boxes of one batch in GPU memory, and those of its clusters of 64 consecutive records.
#pragma once

#include <span>
#include <vector>

#include "sightline/core/snapshot.h"
#include "sightline/gl/buffer.h"
#include "sightline/gpuscene/gpu_scene.h"

namespace sightline::culling {

inline constexpr std::uint32_t kClusterSize = 64;

/// Boxes as core::ItemBounds has them, one per place, read in shaders through a buffer texture.
struct GpuBoxes {
  gl::Buffer corners, layers;  ///< min and max, three floats each; uint32, none when the scene uses no layers
  gl::TextureBuffer corner_texels, layer_texels;

  std::size_t memory_bytes() const { return corners.size() + layers.size(); }
};

/// Follows the records of a gpuscene::Batch: place k is record k. Places without a record, and of vacant slots, hold
/// the empty box.
class GpuBounds {
 public:
  /// `slots`: of the batch's records, in order.
  static core::Expected<GpuBounds> create(const gl::Functions& gl, const core::ItemBounds& bounds,
                                          const gpuscene::Batch& batch, std::vector<core::Slot> slots);

  /// Adds the record of an appended slot; update() must follow with it. The batch has room: see GpuScene::append.
  std::uint32_t append(core::Slot slot);
  /// Writes the boxes of these records anew, and those of their clusters. `changed` is sorted.
  void update(const core::ItemBounds& bounds, std::span<std::uint32_t> changed) const;

  std::uint32_t cluster_count() const { return std::uint32_t((slots_.size() + kClusterSize - 1) / kClusterSize); }
  std::uint32_t cluster_capacity() const { return cluster_capacity_; }
  const std::vector<core::Slot>& slots() const { return slots_; }  ///< by record
  const GpuBoxes& items() const { return items_; }
  const GpuBoxes& clusters() const { return clusters_; }
  std::size_t memory_bytes() const { return items_.memory_bytes() + clusters_.memory_bytes(); }

 private:
  void write(const core::ItemBounds& bounds, std::uint32_t first_cluster, std::uint32_t cluster_end) const;

  std::vector<core::Slot> slots_;
  std::uint32_t cluster_capacity_ = 0;
  GpuBoxes items_, clusters_;
};

}  // namespace sightline::culling
