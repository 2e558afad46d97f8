#include "sightline/gpuscene/internal/mesh_pool.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "sightline/gpuscene/internal/solid_shells.h"

namespace sightline::gpuscene {
namespace {

using core::Kind;
using core::Slot;
using core::Snapshot;

struct Vertex {
  core::vec3 position;
  std::uint32_t normal;
};
static_assert(sizeof(Vertex) == MeshPool::kVertexBytes);

struct Shape {
  std::uint32_t first_index, index_count, solid_indices;
  std::int32_t base_vertex;
};

std::uint32_t snorm16(float v) {
  return std::uint16_t(std::lround(std::clamp(v, -1.0f, 1.0f) * 32767.0f));
}

/// Gathers triangles. Items with the same mesh share them.
class PoolBuilder {
 public:
  explicit PoolBuilder(const Snapshot& snapshot) : snapshot_(snapshot) {}

  Shape shape_of(Slot slot) {
    const std::uint32_t mesh = snapshot_.of_kind(snapshot_.kind(slot)).meshes[snapshot_.index_in_kind(slot)];
    const auto [place, fresh] = shapes_.try_emplace(mesh);
    if (fresh) place->second = append(snapshot_.mesh(slot));
    return place->second;
  }

  const std::vector<Vertex>& vertices() const { return vertices_; }
  const std::vector<std::uint32_t>& indices() const { return indices_; }

 private:
  Shape append(const core::Mesh& mesh) {
    Shape shape{std::uint32_t(indices_.size()), std::uint32_t(mesh.indices.size()), 0, std::int32_t(vertices_.size())};
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
      vertices_.push_back({mesh.positions[i], mesh.normals.empty() ? kNoNormal : pack_normal(mesh.normals[i])});
    }
    indices_.insert(indices_.end(), mesh.indices.begin(), mesh.indices.end());
    shape.solid_indices = solid_shells_first(mesh.positions, std::span(indices_).subspan(shape.first_index));
    return shape;
  }

  const Snapshot& snapshot_;
  std::unordered_map<std::uint32_t, Shape> shapes_;  // by mesh
  std::vector<Vertex> vertices_;
  std::vector<std::uint32_t> indices_;
};

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

core::Expected<MeshPool> build_mesh_pool(const gl::Functions& gl, const Snapshot& snapshot,
                                         std::span<const Slot> slots) {
  PoolBuilder builder(snapshot);
  MeshPool pool;
  pool.commands.reserve(slots.size());
  pool.solid_indices.reserve(slots.size());
  for (const Slot slot : slots) {
    const Shape shape = builder.shape_of(slot);
    pool.commands.push_back({shape.index_count, snapshot.vacant(slot) ? 0u : 1u, shape.first_index, shape.base_vertex,
                             std::uint32_t(pool.commands.size())});
    pool.solid_indices.push_back(shape.solid_indices);
  }
  if (builder.indices().empty()) return pool;  // every mesh is empty: all commands draw zero indices
  auto vertices = gl::Buffer::create(gl, std::span(builder.vertices()), 0, "mesh vertices");
  if (!vertices) return tl::unexpected(vertices.error());
  auto indices = gl::Buffer::create(gl, std::span(builder.indices()), 0, "mesh indices");
  if (!indices) return tl::unexpected(indices.error());
  pool.vertices = std::move(*vertices);
  pool.indices = std::move(*indices);
  return pool;
}

}  // namespace sightline::gpuscene
