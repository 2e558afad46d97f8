// The scene flattened for one generation: structure-of-arrays over items in spatial order. Cullers, renderers and
// tracers are built from it; nobody walks the scene graph per frame.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "sightline/core/bvh_build.h"
#include "sightline/core/item_bounds.h"
#include "sightline/core/scene.h"

namespace sightline::core {

/// Where an item stands: p_chunk = linear * p_item + origin, relative to the origin of its chunk, so that float
/// precision follows the item and not the site.
struct Placement {
  mat3 linear{1.0f};
  vec3 origin{0.0f};
  std::uint32_t chunk = 0;
};

/// The items of one kind, in slot order (parallel arrays).
struct KindItems {
  std::vector<Slot> slots;
  std::vector<Placement> placements;
  std::vector<float> parameters;      ///< parameter_count(kind) floats per item; none for meshes
  std::vector<std::uint32_t> meshes;  ///< mesh index per item; facet groups and meshes only
  std::size_t size() const { return slots.size(); }
};

class Snapshot {
 public:
  /// Builds a generation from the committed scene. Mesh and material data stay in the scene, which must outlive the
  /// snapshot. Snapshots of scenes with pending edits show the edits (commit first to have them validated).
  explicit Snapshot(const Scene& scene, const BvhConfig& config = {});

  /// Follows a commit without re-ordering: changed items get new bounds and placement in their slot, inserted ones go
  /// to a linear tail behind tree_size(), removed ones become empty boxes on no layer. Items are read as the scene has
  /// them now, so deltas may be applied late as long as all of them are, in order: one that a later delta removes is
  /// passed over, one that the snapshot already holds is updated.
  void apply(const SceneDelta& delta);

  const Scene& scene() const { return *scene_; }
  std::size_t size() const { return bounds_.size(); }   ///< slots, those of removed items included
  std::size_t tree_size() const { return tree_size_; }  ///< slots in the order of core::build_bvh; the tail follows
  std::uint64_t generation() const { return generation_; }

  const ItemBounds& bounds() const { return bounds_; }
  Kind kind(Slot slot) const { return kinds_[slot]; }
  std::uint32_t index_in_kind(Slot slot) const { return index_in_kind_[slot]; }
  ItemId item(Slot slot) const { return items_[slot]; }
  Slot slot(ItemId item) const { return item < slots_.size() ? slots_[item] : kNone; }  ///< kNone when unknown
  std::uint32_t material(Slot slot) const { return materials_[slot]; }                  ///< material index or kNone
  const KindItems& of_kind(Kind kind) const { return kind_items_[std::size_t(kind)]; }

  /// Items of `kind` in slots below `slot`: so a range of slots becomes a range of of_kind(kind). Constant time.
  std::uint32_t rank(Kind kind, Slot slot) const;

  /// Origins of the chunks, in world coordinates.
  const std::vector<dvec3>& chunk_origins() const { return chunk_origins_; }
  Affine world_from_item(Slot slot) const;
  Primitive primitive(Slot slot) const;

  std::size_t memory_bytes() const;

 private:
  struct Gathered;
  void append(ItemId item, const Scene::ItemState& state, std::uint32_t chunk);
  /// A chunk within reach of `place`: its own, a likely one, any other, or a new one about `fresh`.
  std::uint32_t chunk_for(const dvec3& place, std::uint32_t own, std::uint32_t likely, const dvec3& fresh);
  void extend_ranks();

  const Scene* scene_;
  std::uint64_t generation_ = 0;
  ItemBounds bounds_;
  std::size_t tree_size_ = 0;
  std::vector<Kind> kinds_;
  std::vector<std::uint32_t> index_in_kind_;
  std::vector<ItemId> items_;
  std::vector<Slot> slots_;
  std::vector<std::uint32_t> materials_;
  std::array<KindItems, kKindCount> kind_items_;
  std::vector<std::array<std::uint32_t, kKindCount>> ranks_;  // per 64 slots: items of each kind before
  std::vector<dvec3> chunk_origins_;
  double chunk_size_ = 0.0;  // metres
};

}  // namespace sightline::core
