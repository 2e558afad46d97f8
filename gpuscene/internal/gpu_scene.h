// gpuscene: the part of a snapshot in GPU memory. This header: batches with their records, the mesh pool, materials.
// Other headers: the kinds of batches (batch_kinds.h) and the visible set on the GPU (draw_lists.h). The module
// neither draws nor culls.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "sightline/core/internal/deadline.h"
#include "sightline/core/snapshot.h"
#include "sightline/gl/context.h"
#include "sightline/gl/internal/buffer.h"
#include "sightline/gpuprims/internal/joints.h"
#include "sightline/gpuscene/internal/batch_kinds.h"
#include "sightline/gpuscene/internal/element_writer.h"
#include "sightline/gpuscene/internal/mesh_pool.h"

namespace sightline::gpuscene {

/// One record per item, in slot order: record k of a ray-cast or line batch belongs to element k of the snapshot's
/// of_kind() arrays.
struct Batch {
  BatchKind kind = BatchKind::kMesh;
  std::uint32_t count = 0;
  std::uint32_t capacity = 0;  ///< records that the memory has room for
  gl::Buffer records;
  gl::TextureBuffer texels;
  gl::Buffer larger;         ///< that records move to, if they do
  std::uint32_t copied = 0;  ///< records that are there, too
};

class GpuScene {
 public:
  /// Uploads everything in the snapshot. Records say which ends `joints` cover; all calls take the joints of the same
  /// snapshot. Fails when the GPU has not enough memory. The context must be current, here and in all other calls.
  static core::Expected<GpuScene> create(const gl::Context& context, const core::Snapshot& snapshot,
                                         const gpuprims::Joints& joints = {});
  /// Uploads in portions: begin(), which uploads nothing, and advance() until it returns true. Each call does at least
  /// a little, and ends a millisecond or so after the deadline. The snapshot may be edited in between: once all is
  /// uploaded, call append(), update() and upload_meshes() with everything that was touched meanwhile. After a failure
  /// the scene is of no use.
  static GpuScene begin(const gl::Context& context, const core::Snapshot& snapshot);
  core::Expected<bool> advance(const core::Snapshot& snapshot, const gpuprims::Joints& joints, core::Deadline deadline);

  GpuScene(GpuScene&&) noexcept;
  GpuScene& operator=(GpuScene&&) noexcept;
  ~GpuScene();

  /// Rewrites the records of changed slots: placement and material, and for vacant slots, which ranges may contain,
  /// nothing to draw. Call append() for appended slots first. Needs at most one GL call per run of neighbours, and
  /// far fewer for many runs (ElementWriter, which lists the GL state that it changes).
  void update(const core::Snapshot& snapshot, std::span<const core::Slot> changed, const gpuprims::Joints& joints = {});
  /// Follows edits that keep placements and shapes: rewrites one word of each record.
  void update_styles(const core::Snapshot& snapshot, std::span<const core::Slot> changed,
                     const gpuprims::Joints& joints = {});
  /// Adds records of the slots appended since the last call, `most` of them, and their kinds. Their meshes are drawn
  /// after upload_meshes(). Where a batch is full it gets half as much again, and the GPU copies what was there. True:
  /// some batches are larger or new, so that who keeps something for each batch (DrawLists, a culler, a renderer) needs
  /// it anew. Fails when the GPU has not enough memory; then the scene is of no use.
  core::Expected<bool> append(const core::Snapshot& snapshot, const gpuprims::Joints& joints = {},
                              core::Slot most = core::kNone);
  /// Whether all slots of the snapshot have records.
  bool has_all(const core::Snapshot& snapshot) const { return slot_count_ == snapshot.size(); }
  /// Writes all edited or added materials at once; `edited` holds their indices in rising order. Makes a larger table
  /// when added ones do not fit. Fails when the GPU has not enough memory; then nothing has changed.
  core::Expected<void> update_materials(const core::Snapshot& snapshot, std::span<const std::uint32_t> edited);

  /// See MeshPool::upload().
  core::Expected<bool> upload_meshes(core::Deadline deadline, bool levels = false) {
    return meshes_.upload(*gl_, deadline, levels);
  }
  /// Follows an edit of `touched` slots at once, as append(), update() and upload_meshes() do. With a deadline, batches
  /// grow some at a time before they are full. Result and failure as those of append().
  core::Expected<bool> follow(const core::Snapshot& snapshot, const gpuprims::Joints& joints,
                              std::span<const core::Slot> touched, core::Deadline deadline);

  const std::vector<Batch>& batches() const { return batches_; }
  const Batch* batch(BatchKind kind) const;  ///< null when the scene has none
  MeshPool& meshes() { return meshes_; }
  const MeshPool& meshes() const { return meshes_; }
  /// By gpuprims::material_row().
  const gl::TextureBuffer& materials() const { return materials_.texels; }
  std::size_t memory_bytes() const;

  /// Number of items of a batch in slots below `slot`. Constant time.
  static std::uint32_t rank(const core::Snapshot& snapshot, BatchKind kind, core::Slot slot);
  /// Place of an item's record in its batch. Equals rank() of its own slot, but is faster.
  static std::uint32_t record_of(const core::Snapshot& snapshot, core::Slot slot);
  /// Slots below `end` of the records of a batch, in order.
  static std::vector<core::Slot> slots_of(const core::Snapshot& snapshot, BatchKind kind, core::Slot end = core::kNone);

 private:
  struct Upload;
  GpuScene();
  /// Slots of one batch, and their records, which rise.
  struct Changed {
    std::vector<std::uint32_t> records;
    std::vector<core::Slot> slots;
  };
  template <class Visit>
  void for_each_batch(const core::Snapshot& snapshot, std::span<const core::Slot> changed, const Visit& visit);
  core::Expected<void> begin_batch(const core::Snapshot& snapshot, BatchKind kind);
  /// Enlarges batches that have little room left, some of it in each call: before each append() of a few hundred slots,
  /// nobody waits until a whole batch is copied. Result and failure as those of append().
  core::Expected<bool> prepare_room();
  core::Expected<bool> make_room(BatchKind kind, std::size_t records);
  core::Expected<bool> enlarge(Batch& batch, std::size_t records, std::uint32_t most);
  void write(const Batch& batch, std::size_t bytes, std::span<const std::uint32_t> places, const void* data);
  core::Expected<void> make_materials(const core::Snapshot& snapshot);

  const gl::Functions* gl_ = nullptr;
  std::vector<Batch> batches_;  // by kind
  MeshPool meshes_;
  gl::TexelArray materials_;
  ElementWriter writer_;
  core::Slot slot_count_ = 0;
  std::unique_ptr<Upload> upload_;  // until everything is uploaded
};

}  // namespace sightline::gpuscene
