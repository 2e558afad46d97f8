// Builds the mesh pool of a GPU scene. Internal to gpuscene.
#pragma once

#include <unordered_map>
#include <vector>

#include "sightline/gpuscene/internal/gpu_scene.h"

namespace sightline::gpuscene {

/// Packs a direction with the octahedral mapping into two snorm16 (Z. Cigolle et al., "A Survey of Efficient
/// Representations for Independent Unit Vectors", 2014), within 7e-5 rad. A vector of no length gives kNoNormal.
/// mesh.vert unpacks it.
std::uint32_t pack_normal(const core::vec3& normal);
inline constexpr std::uint32_t kNoNormal = 0x80008000u;

/// True when an item's mesh has no normals and is shaded flat.
bool flat_shaded(const core::Snapshot& snapshot, core::Slot slot);

/// Gathers and uploads the meshes of all items of the mesh batch. Items with the same mesh share its triangles.
class MeshPoolBuilder {
 public:
  /// The snapshot must stay at its address.
  explicit MeshPoolBuilder(const core::Snapshot& snapshot) : snapshot_(&snapshot) {}

  /// The next slot of the batch; slots must rise.
  void gather(core::Slot slot);
  std::size_t gathered() const { return pool_.commands.size(); }
  /// Of all that was gathered. Leaves nothing behind.
  core::Expected<MeshPool> upload(const gl::Functions& gl);

 private:
  struct Vertex {
    core::vec3 position;
    std::uint32_t normal;
  };
  struct Shape {
    std::uint32_t first_index, index_count, solid_indices;
    std::int32_t base_vertex;
  };
  Shape shape_of(core::Slot slot);
  Shape append(const core::Mesh& mesh);

  const core::Snapshot* snapshot_;
  std::unordered_map<std::uint32_t, Shape> shapes_;  // by mesh
  std::vector<Vertex> vertices_;
  std::vector<std::uint32_t> indices_;
  MeshPool pool_;
};

}  // namespace sightline::gpuscene
