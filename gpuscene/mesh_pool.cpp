#include "sightline/gpuscene/mesh_pool.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "sightline/gpuscene/solid_shells.h"

namespace sightline::gpuscene {
namespace {

using core::Kind;
using core::Slot;
using core::Snapshot;

struct Vertex {
  core::vec3 position;
  std::int16_t normal[4];
};
static_assert(sizeof(Vertex) == MeshPool::kVertexBytes);

struct Shape {
  std::uint32_t first_index, index_count, solid_indices;
  std::int32_t base_vertex;
};

std::int16_t snorm16(float v) {
  return std::int16_t(std::lround(std::clamp(v, -1.0f, 1.0f) * 32767.0f));
}

/// Gathers triangles; items of one mesh share them.
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
      const core::vec3 n = mesh.normals.empty() ? core::vec3(0.0f) : mesh.normals[i];
      const float norm = glm::length(n);
      const core::vec3 unit = norm > 0.0f ? n / norm : core::vec3(0.0f);
      vertices_.push_back({mesh.positions[i], {snorm16(unit.x), snorm16(unit.y), snorm16(unit.z), 0}});
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
  if (builder.indices().empty()) return pool;  // every mesh is empty: commands of zero indices
  auto vertices = gl::Buffer::create(gl, std::span(builder.vertices()), 0, "mesh vertices");
  if (!vertices) return tl::unexpected(vertices.error());
  auto indices = gl::Buffer::create(gl, std::span(builder.indices()), 0, "mesh indices");
  if (!indices) return tl::unexpected(indices.error());
  pool.vertices = std::move(*vertices);
  pool.indices = std::move(*indices);
  return pool;
}

}  // namespace sightline::gpuscene
