// The GPU form of a visible set: which records each batch draws, as indirect commands and record ids.
//
// Ray-cast and box batches draw without attributes: eight vertices per record, the corners of its box, so gl_VertexID /
// 8 names the record and a range of records is a command whose base vertex is eight times the range's first. Vertex ids
// beyond the batch's records name places in the list of single records, read through a buffer texture. Lines do the
// same with two vertices. Meshes bring their record as an attribute with divisor 1, offset by the command's base
// instance.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "sightline/core/snapshot.h"
#include "sightline/core/visible_set.h"
#include "sightline/gpuscene/gpu_scene.h"

namespace sightline::gpuscene {

inline constexpr std::uint32_t kCornersPerRecord = 8;

class DrawLists {
 public:
  /// Where a batch's commands lie in commands(), ElementsCommand each. Lines draw with indices too, 0, 1, 2, …
  struct Section {
    std::size_t offset = 0;  ///< bytes
    int count = 0;           ///< commands; 0: nothing to draw
  };

  static core::Expected<DrawLists> create(const gl::Context& context, const GpuScene& scene);

  /// Translates and uploads a visible set of `snapshot`, from which `scene` was made. Fails when the GPU has not the
  /// memory; then the lists are empty.
  core::Expected<void> update(const core::Snapshot& snapshot, const GpuScene& scene, const core::VisibleSet& visible);

  const Section& section(BatchKind kind) const { return sections_[std::size_t(kind)]; }
  const gl::Buffer& commands() const { return commands_; }
  /// Single records, R32UI; place i is named by record number batch.count + i.
  const gl::TextureBuffer& singles() const { return single_texels_; }
  /// 16-bit index patterns of box and proxy corners; empty when no batch needs them.
  const gl::Buffer& corner_indices() const { return corner_indices_; }
  /// 0, 1, 2, … up to the mesh batch's capacity: the instance attribute of meshes.
  const gl::Buffer& mesh_instances() const { return mesh_instances_; }
  std::size_t memory_bytes() const;

 private:
  void list_records(const core::Snapshot& snapshot, const Batch& batch, const core::VisibleSet& visible);
  void list_meshes(const core::Snapshot& snapshot, const MeshPool& pool, const core::VisibleSet& visible);
  void append_records(BatchKind kind, std::uint32_t first, std::uint32_t count);
  void append(const ElementsCommand* commands, std::size_t count);
  core::Expected<void> upload();
  core::Expected<void> grow_singles(std::size_t capacity);

  static constexpr int kFramesInFlight = 3;  // so that no upload waits for the GPU to finish reading

  const gl::Functions* gl_ = nullptr;
  gl::Buffer commands_, singles_, corner_indices_, mesh_instances_;
  gl::TextureBuffer single_texels_;
  std::size_t command_capacity_ = 0, single_capacity_ = 0;  // commands and ids per frame in flight
  int frame_ = 0;
  std::array<Section, kBatchKindCount> sections_;
  std::vector<ElementsCommand> command_list_;
  std::vector<std::uint32_t> single_list_;
};

}  // namespace sightline::gpuscene
