#include "sightline/core/internal/mesh_table.h"

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

/// A chunk that no other list has. The list of chunks must be such a one.
MeshList::Chunk& MeshTable::own(std::size_t chunk) const {
  auto& place = (*list_.chunks_)[chunk];
  place = std::make_shared<MeshList::Chunk>(*place);
  return *place;
}

void MeshTable::remove(std::span<const std::uint32_t> indices) {
  if (indices.empty()) return;
  list_.chunks_ = std::make_shared<MeshList::Chunks>(*list_.chunks_);
  std::vector<std::uint32_t> sorted(indices.begin(), indices.end());
  std::sort(sorted.begin(), sorted.end());
  assert(sorted.back() < size());
  MeshList::Chunk* chunk = nullptr;
  std::size_t last = 0;
  for (const std::uint32_t index : sorted) {
    if (!chunk || index / MeshList::kChunk != last) chunk = &own(last = index / MeshList::kChunk);
    (*chunk)[index % MeshList::kChunk].reset();
  }
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
