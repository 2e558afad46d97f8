// The triangles of all meshes of a GPU scene, in two buffers. Internal to gpuscene and what draws.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "sightline/core/internal/deadline.h"
#include "sightline/core/snapshot.h"
#include "sightline/gl/internal/buffer.h"
#include "sightline/gpuscene/internal/element_store.h"
#include "sightline/lod/mesh_levels.h"

namespace sightline::gpuscene {

/// Command of glMultiDrawElementsIndirect.
struct ElementsCommand {
  std::uint32_t count, instance_count, first_index;
  std::int32_t base_vertex;
  std::uint32_t base_instance;

  bool operator==(const ElementsCommand&) const = default;
};
static_assert(sizeof(ElementsCommand) == 20);

/// How a mesh is drawn: the command that draws all of it, its levels or null, whose indices begin at the command's
/// first one, and how many of its first indices belong to solid shells, whose back faces cannot be seen from outside
/// (0 where that is not known).
struct DrawnMesh {
  ElementsCommand whole;
  const lod::MeshLevels* levels;
  std::uint32_t solid_indices;
};

/// Packs a direction with the octahedral mapping into two snorm16 (Z. Cigolle et al., "A Survey of Efficient
/// Representations for Independent Unit Vectors", 2014), within 7e-5 rad. A vector of no length gives kNoNormal.
/// mesh.vert unpacks it.
std::uint32_t pack_normal(const core::vec3& normal);
inline constexpr std::uint32_t kNoNormal = 0x80008000u;

/// True when an item's mesh has no normals and is shaded flat.
bool flat_shaded(const core::Snapshot& snapshot, core::Slot slot);

/// Each mesh is stored once, as long as a record of the mesh batch draws it. Records come in slot order. Meshes and
/// their levels are uploaded in portions, and each is drawn once it is there as a whole.
class MeshPool {
 public:
  static constexpr int kVertexBytes = 16;

  /// Adds the record of the next slot of the batch, and its mesh unless another record has it.
  void add(const core::Snapshot& snapshot, core::Slot slot);
  /// Follows an edit of the slot of a record. A record whose slot was given up lets go of its mesh.
  void update(const core::Snapshot& snapshot, core::Slot slot, std::uint32_t record);

  struct LevelsOfMesh {
    std::shared_ptr<const core::Mesh> mesh;
    std::shared_ptr<const lod::MeshLevels> levels;
  };
  /// Takes levels of meshes, where a record has them, to be uploaded in place of others. Their first clusters hold all
  /// triangles of the mesh, which command() draws from then on.
  void add_levels(std::span<const LevelsOfMesh> levels);

  /// Uploads the meshes that were added, until the deadline but at least a few, and then `levels`, if these are wanted.
  /// Returns true once all are drawn. The first buffer has just the memory that they need, since most scenes never get
  /// more. Later ones have half as much again (with levels an eighth), and little more than what is used where that has
  /// become less than half. Without a deadline, solid shells of all meshes are found at once; else those of large
  /// meshes are known with their clusters. Fails when the GPU has not enough memory; then the pool is of no use.
  core::Expected<bool> upload(const gl::Functions& gl, core::Deadline deadline, bool levels = false);
  /// How often buffers have become smaller, since less than half of them was in use.
  int packs() const { return packs_; }
  /// Number of elements that were written or moved, ever: what a portion does, for tests.
  std::uint64_t elements_done() const { return elements_done_; }

  /// Meshes that were added and not yet taken, as far as records still have them: so many at most.
  std::vector<std::shared_ptr<const core::Mesh>> take_new_meshes(std::size_t most);
  bool has_new_meshes() const { return !new_shapes_.empty(); }
  /// Meshes that the last record has given up since the last call, and that no record has got since.
  std::vector<std::shared_ptr<const core::Mesh>> take_gone_meshes();
  std::vector<std::shared_ptr<const core::Mesh>> meshes() const;  ///< all
  bool has(const core::Mesh& mesh) const { return shape_of_mesh_.contains(&mesh); }
  /// Levels with which a record is drawn, or null.
  std::shared_ptr<const lod::MeshLevels> share_levels(std::uint32_t record) const;
  const lod::MeshLevels* levels(std::uint32_t record) const { return drawn(record).levels; }
  /// Rises whenever commands of records that were there before draw from other places, or by levels.
  std::uint64_t version() const { return version_; }

  std::size_t records() const { return shape_of_record_.size(); }
  DrawnMesh drawn(std::uint32_t record) const;
  /// All that a record draws.
  ElementsCommand command(std::uint32_t record) const { return drawn(record).whole; }
  /// Four words each: position x y z as float bits, normal (pack_normal). No buffer while there is no triangle.
  const gl::Buffer& vertices() const { return vertices_.buffer(); }
  const gl::Buffer& indices() const { return indices_.buffer(); }  ///< uint32
  std::size_t memory_bytes() const {
    return vertices_.memory_bytes() + indices_.memory_bytes() + enclosures->bytes.buffer.size();
  }

  /// What the meshes of records enclose (core::Enclosure), a byte each. Created on first use.
  struct Enclosures {
    std::size_t records = 0;
    gl::TexelArray bytes;
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
    std::uint64_t serial = 0;                // no other shape has had it
    bool drawn = false;                      // the mesh is there; the places and counts that follow are its own
    std::uint32_t first_vertex = 0, vertex_count = 0, first_index = 0, index_count = 0;
    std::optional<std::uint32_t> solid_indices;     // none: not known
    std::uint32_t users = 0;                        // records
    std::shared_ptr<const lod::MeshLevels> levels;  // where there are any, their indices lie at first_index
  };
  /// A mesh to be uploaded, or levels of one.
  struct Upload {
    std::uint32_t shape = core::kNone;
    std::uint64_t serial = 0;
    std::shared_ptr<const lod::MeshLevels> levels;  // null: the mesh itself
    std::uint64_t call = 0;                         // number of the call of upload() before which it came
    std::size_t vertex_count = 0, index_count = 0;
  };
  /// The one that is under way, with its places.
  struct Current : Upload {
    std::uint32_t first_vertex = 0, first_index = 0;
    std::size_t vertices = 0, indices = 0;  // of these, staged
    std::vector<std::uint32_t> ordered;     // indices of the mesh in another order than its own; none: in its own
    std::optional<std::uint32_t> solid_indices;
  };

  static std::uint32_t vertex_room(const Shape& shape) { return shape.vertex_count; }
  static std::uint32_t index_room(const Shape& shape) {
    return shape.levels ? std::uint32_t(shape.levels->indices.size()) : shape.index_count;
  }
  std::uint32_t shape_of(std::shared_ptr<const core::Mesh> mesh);
  const Shape* drawn_shape(std::uint32_t record) const;
  void release(std::uint32_t shape);
  void queue(std::deque<Upload>& uploads, Upload upload);
  void give_back_current();
  core::Expected<bool> step(const gl::Functions& gl, bool levels, bool find_solids);
  bool begin_next(bool levels, bool find_solids);
  void end_current();
  void write_staged();
  template <class Element>
  core::Expected<void> make_room(const gl::Functions& gl, ElementStore<Element>& store, std::size_t waiting);
  template <class Element>
  bool move(const gl::Functions& gl, ElementStore<Element>& store, std::uint32_t Shape::*first,
            std::uint32_t (*room)(const Shape&));
  core::Expected<bool> pack_if_wasteful(const gl::Functions& gl);

  ElementStore<Vertex> vertices_{"mesh vertices"};
  ElementStore<std::uint32_t> indices_{"mesh indices"};
  std::uint64_t version_ = 0, serial_ = 0, calls_ = 0, elements_done_ = 0;
  int packs_ = 0;
  bool has_levels_ = false;
  std::vector<std::uint32_t> shape_of_record_;  // kNone: draws nothing any more
  std::vector<bool> hidden_;                    // by record
  std::vector<Shape> shapes_;
  std::vector<std::uint32_t> unused_shapes_, new_shapes_;
  std::vector<std::shared_ptr<const core::Mesh>> gone_meshes_;
  std::unordered_map<const core::Mesh*, std::uint32_t> shape_of_mesh_;
  std::deque<Upload> new_meshes_, new_levels_;
  std::size_t waiting_vertices_ = 0, waiting_indices_ = 0;  // of both
  Current current_;                                         // its shape is kNone where there is none
};

}  // namespace sightline::gpuscene
