// The meshes of a scene by index, shared with its snapshots, so that whoever has a snapshot may read its meshes on any
// thread while the scene is edited.
//
// Meshes never change. They stand in chunks that never move, and a scene appends behind what its snapshots know of:
// other places in memory. Removal makes new chunks, and so does a mesh that gets the index of a removed one. So nothing
// that a MeshList reads is ever written.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "sightline/core/api.h"
#include "sightline/core/mesh.h"

namespace sightline::core {

/// The first size() meshes of a table, as they were when the list was copied. Copies cost the same whatever their size.
class SIGHTLINE_API MeshList {
 public:
  std::size_t size() const { return size_; }
  /// Empty where the mesh was removed, and from size() on.
  const Mesh& operator[](std::size_t index) const;
  /// Null where operator[] is empty for want of a mesh.
  std::shared_ptr<const Mesh> share(std::size_t index) const;

 private:
  friend class MeshTable;
  static constexpr std::size_t kChunk = 64;
  using Chunk = std::array<std::shared_ptr<const Mesh>, kChunk>;
  using Chunks = std::vector<std::shared_ptr<Chunk>>;

  std::shared_ptr<const Mesh>& at(std::size_t index) const { return (*(*chunks_)[index / kChunk])[index % kChunk]; }

  std::shared_ptr<Chunks> chunks_;  // room for more than size_
  std::size_t size_ = 0;
};

/// A scene's own. Threads may read it at once, and one may change it while none reads.
class SIGHTLINE_API MeshTable {
 public:
  MeshTable() = default;
  MeshTable(MeshTable&& other) noexcept { *this = std::move(other); }
  MeshTable& operator=(MeshTable&& other) noexcept;
  /// Shares the meshes. Both tables may then be appended to.
  MeshTable(const MeshTable& other) { append(other); }
  MeshTable& operator=(const MeshTable& other);

  /// To be copied.
  const MeshList& list() const {
    handed_out_.store(true, std::memory_order_relaxed);  // several threads may read a scene
    return list_;
  }
  std::size_t size() const { return list_.size(); }
  const Mesh& operator[](std::size_t index) const { return list_[index]; }

  /// Afterwards neither push_back() nor append() allocates up to this size.
  void reserve(std::size_t size);
  void push_back(std::shared_ptr<const Mesh> mesh);
  void append(const MeshTable& other);
  /// Puts a mesh where one was removed. The first call after list() takes time linear in a 64th of size().
  void set(std::size_t index, std::shared_ptr<const Mesh> mesh);
  /// Lets go of these meshes. Time as that of set().
  void remove(std::span<const std::uint32_t> indices);
  /// Keeps the first `size` meshes, at most as many as there are.
  void truncate(std::size_t size);

 private:
  std::shared_ptr<const Mesh>& writable(std::size_t index);

  MeshList list_;
  std::vector<bool> own_;                       // by chunk: no copy of list_ has it; those from the end on may have one
  mutable std::atomic<bool> handed_out_{true};  // there may be a copy that shares what own_ says nobody shares
};

}  // namespace sightline::core
