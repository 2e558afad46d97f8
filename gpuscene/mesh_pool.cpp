#include "sightline/gpuscene/mesh_pool.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <map>

#include "sightline/gpuprims/primitives.h"

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

/// What makes two items share triangles: the same mesh, or the same shape at the same fineness.
struct ShapeKey {
  Kind kind;
  int tolerance_class;
  std::array<std::uint32_t, 9> words{};
  auto operator<=>(const ShapeKey&) const = default;
};

struct Shape {
  std::uint32_t first_index, index_count;
  std::int32_t base_vertex;
};

std::int16_t snorm16(float v) {
  return std::int16_t(std::lround(std::clamp(v, -1.0f, 1.0f) * 32767.0f));
}

double largest_scale(const core::Placement& placement) {
  const core::dmat3 m(placement.linear);
  return std::max({glm::length(m[0]), glm::length(m[1]), glm::length(m[2])});
}

const core::Placement& placement_of(const Snapshot& snapshot, Slot slot) {
  return snapshot.of_kind(snapshot.kind(slot)).placements[snapshot.index_in_kind(slot)];
}

core::MeshId mesh_of(const Snapshot& snapshot, Slot slot) {
  return snapshot.scene().mesh_at(snapshot.of_kind(snapshot.kind(slot)).meshes[snapshot.index_in_kind(slot)]);
}

class PoolBuilder {
 public:
  PoolBuilder(const Snapshot& snapshot, const GpuSceneConfig& config) : snapshot_(snapshot), config_(config) {}

  Shape shape_of(Slot slot) {
    const ShapeKey key = key_of(slot);
    const auto found = shapes_.find(key);
    if (found != shapes_.end()) return found->second;
    const Kind kind = snapshot_.kind(slot);
    const Shape shape = int(kind) >= core::kPrimitiveKindCount
                            ? append(snapshot_.scene().mesh(mesh_of(snapshot_, slot)))
                            : append(gpuprims::tessellate(snapshot_.primitive(slot), fineness(key.tolerance_class)));
    shapes_.emplace(key, shape);
    return shape;
  }

  const std::vector<Vertex>& vertices() const { return vertices_; }
  const std::vector<std::uint32_t>& indices() const { return indices_; }

 private:
  ShapeKey key_of(Slot slot) const {
    ShapeKey key{snapshot_.kind(slot), 0};
    if (int(key.kind) >= core::kPrimitiveKindCount) {
      key.words[0] = mesh_of(snapshot_, slot).index;
      return key;
    }
    const core::Primitive primitive = snapshot_.primitive(slot);
    const auto values = core::parameters(primitive);
    std::memcpy(key.words.data(), values.data(), values.size_bytes());
    // Local tolerances are rounded down to powers of two, so that equal shapes under nearly equal scales share.
    const double scale = largest_scale(placement_of(snapshot_, slot));
    key.tolerance_class = scale > 0.0 ? std::ilogb(config_.chord_tolerance / scale) : 0;
    return key;
  }

  gpuprims::Tessellation fineness(int tolerance_class) const {
    gpuprims::Tessellation t;
    t.chord_tolerance = std::ldexp(1.0, tolerance_class);
    t.min_segments = std::min(16, config_.max_segments);
    t.max_segments = config_.max_segments;
    return t;
  }

  Shape append(const core::Mesh& mesh) {
    const Shape shape{std::uint32_t(indices_.size()), std::uint32_t(mesh.indices.size()),
                      std::int32_t(vertices_.size())};
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
      const core::vec3 n = mesh.normals.empty() ? core::vec3(0.0f) : mesh.normals[i];
      const float norm = glm::length(n);
      const core::vec3 unit = norm > 0.0f ? n / norm : core::vec3(0.0f);
      vertices_.push_back({mesh.positions[i], {snorm16(unit.x), snorm16(unit.y), snorm16(unit.z), 0}});
    }
    indices_.insert(indices_.end(), mesh.indices.begin(), mesh.indices.end());
    return shape;
  }

  const Snapshot& snapshot_;
  GpuSceneConfig config_;
  std::map<ShapeKey, Shape> shapes_;
  std::vector<Vertex> vertices_;
  std::vector<std::uint32_t> indices_;
};

}  // namespace

bool flat_shaded(const Snapshot& snapshot, Slot slot) {
  return int(snapshot.kind(slot)) >= core::kPrimitiveKindCount &&
         snapshot.scene().mesh(mesh_of(snapshot, slot)).normals.empty();
}

core::Expected<MeshPool> build_mesh_pool(const gl::Functions& gl, const Snapshot& snapshot, std::span<const Slot> slots,
                                         const GpuSceneConfig& config) {
  PoolBuilder builder(snapshot, config);
  MeshPool pool;
  pool.commands.reserve(slots.size());
  for (const Slot slot : slots) {
    const Shape shape = builder.shape_of(slot);
    pool.commands.push_back({shape.index_count, snapshot.vacant(slot) ? 0u : 1u, shape.first_index, shape.base_vertex,
                             std::uint32_t(pool.commands.size())});
  }
  if (builder.indices().empty()) return pool;  // every shape is empty: commands of zero indices
  auto vertices = gl::Buffer::create(gl, std::span(builder.vertices()), 0, "mesh vertices");
  if (!vertices) return tl::unexpected(vertices.error());
  auto indices = gl::Buffer::create(gl, std::span(builder.indices()), 0, "mesh indices");
  if (!indices) return tl::unexpected(indices.error());
  pool.vertices = std::move(*vertices);
  pool.indices = std::move(*indices);
  return pool;
}

}  // namespace sightline::gpuscene
