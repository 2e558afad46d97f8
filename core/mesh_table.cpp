#include "sightline/core/mesh_table.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace sightline::core {

const Mesh& MeshList::operator[](std::size_t index) const {
  static const Mesh kNothing;
  const Mesh* mesh = index < size_ ? at(index).get() : nullptr;
  return mesh ? *mesh : kNothing;
}

std::shared_ptr<const Mesh> MeshList::share(std::size_t index) const {
  return index < size_ ? at(index) : nullptr;
}

MeshTable& MeshTable::operator=(MeshTable&& other) noexcept {
  list_ = std::exchange(other.list_, {});
  own_ = std::exchange(other.own_, {});
  handed_out_ = other.handed_out_.load();
  return *this;
}

MeshTable& MeshTable::operator=(const MeshTable& other) {
  if (this != &other) *this = MeshTable(other);
  return *this;
}

void MeshTable::reserve(std::size_t size) {
  const std::size_t chunks = (size + MeshList::kChunk - 1) / MeshList::kChunk;
  const std::size_t present = list_.chunks_ ? list_.chunks_->size() : 0;
  const std::size_t used = (list_.size_ + MeshList::kChunk - 1) / MeshList::kChunk;
  if (chunks > present) {
    auto more = std::make_shared<MeshList::Chunks>(std::max(chunks, 2 * present));
    if (list_.chunks_) std::copy_n(list_.chunks_->begin(), present, more->begin());
    list_.chunks_ = std::move(more);
  }
  for (std::size_t i = used; i < chunks; ++i)
    if (auto& chunk = (*list_.chunks_)[i]; !chunk) chunk = std::make_shared<MeshList::Chunk>();
}

void MeshTable::push_back(std::shared_ptr<const Mesh> mesh) {
  reserve(list_.size_ + 1);
  list_.at(list_.size_++) = std::move(mesh);
}

void MeshTable::append(const MeshTable& other) {
  reserve(list_.size_ + other.size());
  for (std::size_t i = 0; i < other.size(); ++i) list_.at(list_.size_++) = other.list_.share(i);
}

/// The place of a mesh, in a chunk that no other list has.
std::shared_ptr<const Mesh>& MeshTable::writable(std::size_t index) {
  assert(index < size());
  if (handed_out_.exchange(false, std::memory_order_relaxed)) {
    list_.chunks_ = std::make_shared<MeshList::Chunks>(*list_.chunks_);
    own_.clear();
  }
  const std::size_t chunk = index / MeshList::kChunk;
  if (chunk >= own_.size()) own_.resize(chunk + 1);
  if (!own_[chunk]) {
    auto& place = (*list_.chunks_)[chunk];
    place = std::make_shared<MeshList::Chunk>(*place);
    own_[chunk] = true;
  }
  return list_.at(index);
}

void MeshTable::set(std::size_t index, std::shared_ptr<const Mesh> mesh) {
  writable(index) = std::move(mesh);
}

void MeshTable::remove(std::span<const std::uint32_t> indices) {
  for (const std::uint32_t index : indices) writable(index).reset();
}

void MeshTable::truncate(std::size_t size) {
  assert(size <= list_.size_);
  if (size == list_.size_) return;
  MeshTable kept;
  kept.reserve(size);
  for (std::size_t i = 0; i < size; ++i) kept.list_.at(kept.list_.size_++) = list_.share(i);
  *this = std::move(kept);
}

}  // namespace sightline::core
