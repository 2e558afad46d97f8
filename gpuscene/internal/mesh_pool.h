// The triangles of all meshes of a GPU scene, in two buffers. Internal to gpuscene and what draws.
#pragma once

#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "sightline/core/snapshot.h"
#include "sightline/gl/internal/buffer.h"
#include "sightline/gpuscene/internal/free_space.h"
#include "sightline/lod/mesh_levels.h"

namespace sightline::gpuscene {

/// Command of glMultiDrawElementsIndirect.
struct ElementsCommand {
  std::uint32_t count, instance_count, first_index;
  std::int32_t base_vertex;
  std::uint32_t base_instance;
};
static_assert(sizeof(ElementsCommand) == 20);

/// Packs a direction with the octahedral mapping into two snorm16 (Z. Cigolle et al., "A Survey of Efficient
/// Representations for Independent Unit Vectors", 2014), within 7e-5 rad. A vector of no length gives kNoNormal.
/// mesh.vert unpacks it.
std::uint32_t pack_normal(const core::vec3& normal);
inline constexpr std::uint32_t kNoNormal = 0x80008000u;

/// True when an item's mesh has no normals and is shaded flat.
bool flat_shaded(const core::Snapshot& snapshot, core::Slot slot);

/// Each mesh is stored once, as long as a record of the mesh batch draws it. Records come in slot order; what they and
/// their meshes lack on the GPU is there after flush().
class MeshPool {
 public:
  static constexpr int kVertexBytes = 16;

  /// Adds the record of the next slot of the batch, and its mesh unless another record has it.
  void add(const core::Snapshot& snapshot, core::Slot slot);
  /// Follows an edit of the slot of a record. A record whose slot was given up lets go of its mesh.
  void update(const core::Snapshot& snapshot, core::Slot slot, std::uint32_t record);
  /// Writes the meshes that were added. The first call takes the memory that they need, since most scenes never get
  /// more. Later ones take half as much again where that is used up (for levels an eighth), and the GPU copies what was
  /// there. Fails when the
  /// GPU has not enough memory; then the pool is of no use.
  core::Expected<void> flush(const gl::Functions& gl);

  /// Takes as much memory as another pool has, before the first flush(): so that many may follow, and none copies.
  core::Expected<void> reserve_as(const gl::Functions& gl, const MeshPool& other);

  /// Meshes that were added since the last call, as far as records still have them; or all of them.
  std::vector<std::shared_ptr<const core::Mesh>> take_new_meshes();
  std::vector<std::shared_ptr<const core::Mesh>> meshes() const;
  struct LevelsOfMesh {
    std::shared_ptr<const core::Mesh> mesh;
    std::shared_ptr<const lod::MeshLevels> levels;
  };
  /// Puts levels of meshes, where a record has them, in place of others; flush() writes them. Their first clusters hold
  /// all triangles of the mesh, so commands() use these from then on.
  void add_levels(std::span<const LevelsOfMesh> levels);
  /// Levels of a record's mesh, or null. Their indices begin at the first one of the record's command.
  const lod::MeshLevels* levels(std::uint32_t record) const;
  std::shared_ptr<const lod::MeshLevels> share_levels(std::uint32_t record) const;
  /// Rises whenever meshes have got levels.
  std::uint64_t levels_version() const { return levels_version_; }

  std::size_t records() const { return commands_.size(); }
  /// One per record: all that it draws.
  const std::vector<ElementsCommand>& commands() const { return commands_; }
  /// How many of the first indices of a record's command belong to solid shells, whose back faces cannot be seen from
  /// outside.
  std::uint32_t solid_indices(std::uint32_t record) const;
  /// Four words each: position x y z as float bits, normal (pack_normal). No buffer while there is no triangle.
  const gl::Buffer& vertices() const { return vertices_.buffer; }
  const gl::Buffer& indices() const { return indices_.buffer; }  ///< uint32
  std::size_t memory_bytes() const { return vertices().size() + indices().size() + enclosures->bytes.size(); }

  /// What the meshes of records enclose (core::Enclosure), a byte each. Made by who first needs it.
  struct Enclosures {
    std::size_t records = 0;
    gl::Buffer bytes;
    gl::TextureBuffer texels;
  };
  std::shared_ptr<Enclosures> enclosures = std::make_shared<Enclosures>();

 private:
  struct Vertex {
    core::vec3 position;
    std::uint32_t normal;
  };
  static_assert(sizeof(Vertex) == kVertexBytes);
  struct Shape {
    std::shared_ptr<const core::Mesh> mesh;  // keeps its address from being another's
    std::uint32_t first_index, index_count, first_vertex, vertex_count, solid_indices;
    std::uint32_t users;                            // records
    std::shared_ptr<const lod::MeshLevels> levels;  // where there are any, their indices lie at first_index
  };
  /// A buffer, its places, and what waits for flush().
  template <class Element>
  struct Store {
    /// Elements of `staged` from `begin` to the next run's come to neighbouring places from `first` on.
    struct Run {
      std::uint32_t first;
      std::size_t begin;
    };
    gl::Buffer buffer;
    bool writable = false;
    FreeSpace space;
    std::vector<Element> staged;
    std::vector<Run> runs;

    std::uint32_t begin_run(std::size_t count);
    core::Expected<void> flush(const gl::Functions& gl, const char* what, std::size_t headroom = 2);
    core::Expected<void> make_writable(const gl::Functions& gl, std::size_t bytes, const char* what);
  };
  std::uint32_t shape_of(std::shared_ptr<const core::Mesh> mesh);
  void stage(Shape& shape);
  bool add_levels(const LevelsOfMesh& of);
  void free_indices(const Shape& shape);

  Store<Vertex> vertices_;
  Store<std::uint32_t> indices_;
  std::uint64_t levels_version_ = 0;
  std::vector<ElementsCommand> commands_;
  std::vector<std::uint32_t> shape_of_record_;  // kNone: draws nothing any more
  std::vector<Shape> shapes_;
  std::vector<std::uint32_t> unused_shapes_, new_shapes_;
  std::unordered_map<const core::Mesh*, std::uint32_t> shape_of_mesh_;
};

}  // namespace sightline::gpuscene
