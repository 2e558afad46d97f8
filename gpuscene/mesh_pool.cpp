#include "sightline/gpuscene/internal/mesh_pool.h"

#include <algorithm>
#include <cmath>

#include "sightline/gpuscene/internal/solid_shells.h"

namespace sightline::gpuscene {
namespace {

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

void MeshPoolBuilder::gather(Slot slot) {
  const bool given_up = snapshot_->item(slot) == core::kNone;  // it never shows again
  const Shape shape = given_up ? Shape{} : shape_of(slot);
  pool_.commands.push_back({shape.index_count, snapshot_->vacant(slot) ? 0u : 1u, shape.first_index, shape.base_vertex,
                            std::uint32_t(pool_.commands.size())});
  pool_.solid_indices.push_back(shape.solid_indices);
}

MeshPoolBuilder::Shape MeshPoolBuilder::shape_of(Slot slot) {
  const std::uint32_t mesh = snapshot_->of_kind(snapshot_->kind(slot)).meshes[snapshot_->index_in_kind(slot)];
  const auto [place, fresh] = shapes_.try_emplace(mesh);
  if (fresh) place->second = append(snapshot_->mesh(slot));
  return place->second;
}

MeshPoolBuilder::Shape MeshPoolBuilder::append(const core::Mesh& mesh) {
  Shape shape{std::uint32_t(indices_.size()), std::uint32_t(mesh.indices.size()), 0, std::int32_t(vertices_.size())};
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    vertices_.push_back({mesh.positions[i], mesh.normals.empty() ? kNoNormal : pack_normal(mesh.normals[i])});
  }
  indices_.insert(indices_.end(), mesh.indices.begin(), mesh.indices.end());
  shape.solid_indices = solid_shells_first(mesh.positions, std::span(indices_).subspan(shape.first_index));
  return shape;
}

core::Expected<MeshPool> MeshPoolBuilder::upload(const gl::Functions& gl) {
  static_assert(sizeof(Vertex) == MeshPool::kVertexBytes);
  if (indices_.empty()) return std::move(pool_);  // every mesh is empty: all commands draw zero indices
  auto vertices = gl::Buffer::create(gl, std::span(vertices_), 0, "mesh vertices");
  if (!vertices) return tl::unexpected(vertices.error());
  auto indices = gl::Buffer::create(gl, std::span(indices_), 0, "mesh indices");
  if (!indices) return tl::unexpected(indices.error());
  pool_.vertices = std::move(*vertices);
  pool_.indices = std::move(*indices);
  return std::move(pool_);
}

}  // namespace sightline::gpuscene
