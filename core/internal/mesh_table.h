// The meshes of a scene by index, shared with its snapshots, so that whoever has a snapshot may read its meshes on any
// thread while the scene is edited.
//
// Meshes never change. They stand in chunks that never move, and a scene appends behind what its snapshots know of:
// other places in memory. Removal makes new chunks. So nothing that a MeshList reads is ever written.
#pragma once

#include <array>
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

/// A scene's own. One thread at a time uses it.
class SIGHTLINE_API MeshTable {
 public:
  MeshTable() = default;
  MeshTable(MeshTable&&) = default;
  MeshTable& operator=(MeshTable&&) = default;
  /// Shares the meshes. Both tables may then be appended to.
  MeshTable(const MeshTable& other) { append(other); }
  MeshTable& operator=(const MeshTable& other);

  const MeshList& list() const { return list_; }
  std::size_t size() const { return list_.size(); }
  const Mesh& operator[](std::size_t index) const { return list_[index]; }

  /// Afterwards neither push_back() nor append() allocates up to this size.
  void reserve(std::size_t size);
  void push_back(std::shared_ptr<const Mesh> mesh);
  void append(const MeshTable& other);
  /// Lets go of these meshes. Time linear in their number and in a 64th of size().
  void remove(std::span<const std::uint32_t> indices);
  /// Keeps the first `size` meshes, at most as many as there are.
  void truncate(std::size_t size);

 private:
  MeshList::Chunk& own(std::size_t chunk) const;

  MeshList list_;
};

}  // namespace sightline::core
