#include "sightline/gpuscene/internal/mesh_pool.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sightline/lod/internal/solid_shells.h"

namespace sightline::gpuscene {
namespace {

using core::kNoItem;
using core::kNone;
using core::Slot;
using core::Snapshot;

std::uint32_t snorm16(float v) {
  return std::uint16_t(std::lround(std::clamp(v, -1.0f, 1.0f) * 32767.0f));
}

}  // namespace

std::uint32_t pack_normal(const core::vec3& normal) {
  const float sum = std::abs(normal.x) + std::abs(normal.y) + std::abs(normal.z);
  if (!(sum > 0.0f) || !std::isfinite(sum)) return kNoNormal;
  glm::vec2 p = glm::vec2(normal) / sum;
  if (normal.z < 0.0f) p = {std::copysign(1.0f - std::abs(p.y), p.x), std::copysign(1.0f - std::abs(p.x), p.y)};
  return snorm16(p.x) | snorm16(p.y) << 16;
}

bool flat_shaded(const Snapshot& snapshot, Slot slot) {
  return int(snapshot.kind(slot)) >= core::kPrimitiveKindCount && snapshot.mesh(slot).normals.empty();
}

// --- records ---------------------------------------------------------------------------------------------------------

void MeshPool::add(const Snapshot& snapshot, Slot slot) {
  const bool given_up = snapshot.item(slot) == kNoItem;  // it never shows again
  const std::uint32_t shape = given_up ? kNone : shape_of(snapshot.share_mesh(slot));
  ElementsCommand command{0, snapshot.vacant(slot) ? 0u : 1u, 0, 0, std::uint32_t(commands_.size())};
  if (shape != kNone) {
    ++shapes_[shape].users;
    command.count = shapes_[shape].index_count;
    command.first_index = shapes_[shape].first_index;
    command.base_vertex = std::int32_t(shapes_[shape].first_vertex);
  }
  commands_.push_back(command);
  shape_of_record_.push_back(shape);
}

void MeshPool::update(const Snapshot& snapshot, Slot slot, std::uint32_t record) {
  commands_[record].instance_count = snapshot.vacant(slot) ? 0 : 1;
  if (snapshot.item(slot) != kNoItem || shape_of_record_[record] == kNone) return;
  commands_[record].count = 0;
  const std::uint32_t index = std::exchange(shape_of_record_[record], kNone);
  Shape& shape = shapes_[index];
  if (--shape.users > 0) return;
  vertices_.space.give_back(shape.first_vertex, shape.vertex_count);
  free_indices(shape);
  shape_of_mesh_.erase(shape.mesh.get());
  shape = {};
  unused_shapes_.push_back(index);
}

std::uint32_t MeshPool::solid_indices(std::uint32_t record) const {
  const std::uint32_t shape = shape_of_record_[record];
  return shape == kNone ? 0 : shapes_[shape].solid_indices;
}

/// kNone where there is no mesh.
std::uint32_t MeshPool::shape_of(std::shared_ptr<const core::Mesh> mesh) {
  if (!mesh) return kNone;
  const auto [place, fresh] = shape_of_mesh_.try_emplace(mesh.get(), std::uint32_t(shapes_.size()));
  if (!fresh) return place->second;
  if (unused_shapes_.empty()) {
    shapes_.emplace_back();
  } else {
    place->second = unused_shapes_.back();
    unused_shapes_.pop_back();
  }
  Shape& shape = shapes_[place->second];
  shape.mesh = std::move(mesh);
  stage(shape);
  new_shapes_.push_back(place->second);
  return place->second;
}

// --- triangles -------------------------------------------------------------------------------------------------------

void MeshPool::stage(Shape& shape) {
  const core::Mesh& mesh = *shape.mesh;
  shape.vertex_count = std::uint32_t(mesh.positions.size());
  shape.index_count = std::uint32_t(mesh.indices.size());
  shape.first_vertex = vertices_.begin_run(shape.vertex_count);
  for (std::size_t i = 0; i < mesh.positions.size(); ++i)
    vertices_.staged.push_back({mesh.positions[i], mesh.normals.empty() ? kNoNormal : pack_normal(mesh.normals[i])});
  shape.first_index = indices_.begin_run(shape.index_count);
  indices_.staged.insert(indices_.staged.end(), mesh.indices.begin(), mesh.indices.end());
  shape.solid_indices = lod::solid_shells_first(mesh.positions, std::span(indices_.staged).last(mesh.indices.size()));
}

std::vector<std::shared_ptr<const core::Mesh>> MeshPool::take_new_meshes() {
  std::vector<std::shared_ptr<const core::Mesh>> meshes;
  for (const std::uint32_t shape : std::exchange(new_shapes_, {}))
    if (shapes_[shape].mesh) meshes.push_back(shapes_[shape].mesh);
  return meshes;
}

std::vector<std::shared_ptr<const core::Mesh>> MeshPool::meshes() const {
  std::vector<std::shared_ptr<const core::Mesh>> meshes;
  for (const Shape& shape : shapes_)
    if (shape.mesh) meshes.push_back(shape.mesh);
  return meshes;
}

void MeshPool::add_levels(std::span<const LevelsOfMesh> levels) {
  bool any = false;
  for (const LevelsOfMesh& of : levels) any |= add_levels(of);
  if (!any) return;
  ++levels_version_;
  for (std::size_t record = 0; record < commands_.size(); ++record)
    if (shape_of_record_[record] != kNone)
      commands_[record].first_index = shapes_[shape_of_record_[record]].first_index;
}

/// Whether these are new.
bool MeshPool::add_levels(const LevelsOfMesh& of) {
  const auto place = shape_of_mesh_.find(of.mesh.get());
  if (place == shape_of_mesh_.end() || of.levels->empty()) return false;
  Shape& shape = shapes_[place->second];
  // Levels from a file may be those of another mesh.
  if (shape.levels == of.levels || shape.solid_indices != of.levels->solid_indices) return false;
  free_indices(shape);
  shape.first_index = indices_.begin_run(of.levels->indices.size());
  indices_.staged.insert(indices_.staged.end(), of.levels->indices.begin(), of.levels->indices.end());
  shape.levels = of.levels;
  return true;
}

void MeshPool::free_indices(const Shape& shape) {
  const std::size_t count = shape.levels ? shape.levels->indices.size() : shape.index_count;
  indices_.space.give_back(shape.first_index, std::uint32_t(count));
}

const lod::MeshLevels* MeshPool::levels(std::uint32_t record) const {
  const std::uint32_t shape = shape_of_record_[record];
  return shape == kNone ? nullptr : shapes_[shape].levels.get();
}

std::shared_ptr<const lod::MeshLevels> MeshPool::share_levels(std::uint32_t record) const {
  const std::uint32_t shape = shape_of_record_[record];
  return shape == kNone ? nullptr : shapes_[shape].levels;
}

core::Expected<void> MeshPool::reserve_as(const gl::Functions& gl, const MeshPool& other) {
  if (other.indices().size() == 0) return {};
  auto done = vertices_.make_writable(gl, other.vertices().size(), "mesh vertices");
  return done ? indices_.make_writable(gl, other.indices().size(), "mesh indices") : done;
}

core::Expected<void> MeshPool::flush(const gl::Functions& gl) {
  auto done = vertices_.flush(gl, "mesh vertices");
  return done ? indices_.flush(gl, "mesh indices", levels_version_ > 0 ? 8 : 2) : done;
}

/// The place of the next `count` elements that are staged.
template <class Element>
std::uint32_t MeshPool::Store<Element>::begin_run(std::size_t count) {
  const std::uint32_t first = space.take(std::uint32_t(count));
  const bool joins = !runs.empty() && runs.back().first + (staged.size() - runs.back().begin) == first;
  if (!joins && count > 0) runs.push_back({first, staged.size()});
  return first;
}

template <class Element>
core::Expected<void> MeshPool::Store<Element>::flush(const gl::Functions& gl, const char* what, std::size_t headroom) {
  if (staged.empty()) return {};
  const std::size_t needed = std::max<std::size_t>(space.end(), 1) * sizeof(Element);
  if (buffer.size() == 0 && runs.size() == 1) {
    auto made = gl::Buffer::create(gl, std::span(staged), 0, what);
    if (!made) return tl::unexpected(made.error());
    buffer = std::move(*made);
  } else {
    const std::size_t elements = std::max(needed, buffer.size()) / sizeof(Element);
    if (!writable || needed > buffer.size())
      if (auto done = make_writable(gl, (elements + elements / headroom) * sizeof(Element), what); !done) return done;
    for (std::size_t i = 0; i < runs.size(); ++i) {
      const std::size_t begin = runs[i].begin, end = i + 1 < runs.size() ? runs[i + 1].begin : staged.size();
      buffer.write(runs[i].first * sizeof(Element), (end - begin) * sizeof(Element), staged.data() + begin);
    }
  }
  staged = {};
  runs = {};
  return {};
}

template <class Element>
core::Expected<void> MeshPool::Store<Element>::make_writable(const gl::Functions& gl, std::size_t bytes,
                                                             const char* what) {
  auto made = buffer.enlarged(gl, bytes, GL_DYNAMIC_STORAGE_BIT, what);
  if (!made) return tl::unexpected(made.error());
  buffer = std::move(*made);
  writable = true;
  return {};
}

}  // namespace sightline::gpuscene
