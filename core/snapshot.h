// The scene flattened for one generation: structure-of-arrays over items in spatial order. Cullers, renderers and
// tracers are built from it, so that nothing walks the scene graph per frame.
//
// A snapshot follows edits without re-ordering. A slot is vacant when its item is hidden, was removed, has moved to
// another slot, or has no geometry. A vacant slot has the empty box and nothing to draw. Cullers may include vacant
// slots in ranges. Code that counts or draws must leave them out.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "sightline/core/api.h"
#include "sightline/core/detail/chunk_grid.h"
#include "sightline/core/item_bounds.h"
#include "sightline/core/large_array.h"
#include "sightline/core/mesh_table.h"
#include "sightline/core/scene.h"
#include "sightline/core/visible_set.h"

namespace sightline::core {

/// Where an item stands: p_chunk = linear * p_item + origin, relative to the origin of its chunk. So float precision
/// follows the item and not the site.
struct Placement {
  mat3 linear{1.0f};
  vec3 origin{0.0f};
  std::uint32_t chunk = 0;
};

/// The items of one kind, in slot order (parallel arrays).
struct KindItems {
  LargeArray<Slot> members;
  LargeArray<Placement> placements;
  LargeArray<float> parameters;      ///< parameter_count(kind) floats per item; none for meshes
  LargeArray<std::uint32_t> meshes;  ///< mesh index per item; facet groups and meshes only
  std::size_t size() const { return members.size(); }
};

/// Colour and alpha of each material, by material index. A removed material has the default ones. Looks that override
/// those of the scene follow: Snapshot::first_override_row().
using MaterialTable = std::vector<glm::vec4>;

class SIGHTLINE_API Snapshot {
 public:
  /// Builds a generation from the committed scene, which must outlive the snapshot. Meshes are shared with it.
  /// Snapshots of scenes with pending edits show the edits (commit first to have them validated). `threads` share the
  /// work; 0: all that OpenMP offers, for few items one. The result does not depend on them.
  explicit Snapshot(const Scene& scene, int threads = 0);

  /// Applies the edits of a commit. Returns the slots below the former size() whose boxes, layers or items changed,
  /// each once.
  ///
  /// An item stays in its slot while its block of 32 slots keeps about the size that it was ordered to. An item that
  /// leaves its block gives up its slot. It is appended together with the inserted items, in spatial order among
  /// themselves.
  ///
  /// Items are read as they are in the scene now. So deltas may be applied late, as long as all of them are applied in
  /// order: an item that a later delta removes is skipped, an item that the snapshot already holds is updated.
  ///
  /// Time is proportional to the size of the delta, not of the snapshot, with two exceptions: reading an eighth of a
  /// byte per slot always, and the material table when materials were edited.
  std::vector<Slot> apply(const SceneDelta& delta);

  // --- overrides ---------------------------------------------------------------------------------------------------
  // What one viewer shows otherwise than the scene says. The caller must save the original values. apply()
  // makes the items of a delta what the scene says, so that they must be overridden again. Copies of items, and what is
  // built from them, are as overridden.

  /// Where an item shows, relative to the origin of the bounds, and on which layers.
  struct Shown {
    Aabb box;
    std::uint32_t layers = 0;
  };
  Shown shown(Slot slot) const { return {bounds_.box(slot), bounds_.layers(slot)}; }
  /// Makes slots vacant.
  void hide(std::span<const Slot> slots);
  /// Makes slots show what shown() returned before they were hidden.
  void show(std::span<const Slot> slots, std::span<const Shown> as);
  /// `material`: of the scene, kNone, or first_override_row() + the number of an override.
  void set_material(Slot slot, std::uint32_t material) {
    stored_.reset();
    materials_[slot] = material;
  }
  /// Sets an override's colour and alpha beside the scene's materials. Numbers should be small: lower ones take memory,
  /// too.
  void set_override_row(std::uint32_t number, const glm::vec4& style);
  /// Material index of the first override; 0 before the first set_override_row(). apply() changes it when the scene has
  /// got many more materials.
  std::uint32_t first_override_row() const { return std::uint32_t(table_->first_override_row); }

  /// Slots appended or given up since the order was made. A new scene version would remove this disorder.
  std::size_t disorder() const { return size() - ordered_size_ + given_up_; }

  const Scene& scene() const { return *scene_; }
  std::size_t size() const { return bounds_.size(); }  ///< slots, vacant ones included
  std::uint64_t generation() const { return generation_; }

  const ItemBounds& bounds() const { return bounds_; }
  bool vacant(Slot slot) const { return bounds_.vacant(slot); }
  std::size_t vacant_count() const { return vacant_before_.empty() ? 0 : vacant_before_.back(); }
  /// The first vacant or first occupied slot of first … end - 1; `end` when there is none. Looks at 64 slots a step,
  /// and at none while no slot is vacant.
  Slot first_vacant(Slot first, Slot end) const { return vacant_count() == 0 ? end : first_where(true, first, end); }
  Slot first_occupied(Slot first, Slot end) const {
    return vacant_count() == 0 ? first : first_where(false, first, end);
  }
  /// Number of visible items: slots of the set that are not vacant. Time linear in the set's ranges alone.
  std::uint64_t count(const VisibleSet& visible) const;
  Kind kind(Slot slot) const { return kinds_[slot]; }
  std::uint32_t index_in_kind(Slot slot) const { return index_in_kind_[slot]; }
  /// kNoItem when the slot was given up; hidden items keep theirs.
  ItemId item(Slot slot) const { return items_[slot]; }
  /// kNone when the item is unknown.
  Slot slot(ItemId item) const {
    const std::uint32_t index = to_index(item);
    return index < slots_.size() ? slots_[index] : kNone;
  }
  std::uint32_t material(Slot slot) const { return materials_[slot]; }  ///< material index or kNone
  const MaterialTable& materials() const { return table_->rows; }
  bool opaque(Slot slot) const { return materials_[slot] == kNone || table_->rows[materials_[slot]].a >= 1.0f; }
  /// The mesh of an item that has one. Empty when the scene had removed the mesh before the last apply(), which it may
  /// do once the item is removed. The scene is not read.
  const Mesh& mesh(Slot slot) const;
  std::shared_ptr<const Mesh> share_mesh(Slot slot) const;  ///< null where mesh() is empty for want of one
  const KindItems& of_kind(Kind kind) const { return kind_items_[std::size_t(kind)]; }

  /// Number of items of `kind` in slots below `slot`. Turns a range of slots into a range of of_kind(kind). Constant
  /// time.
  std::uint32_t rank(Kind kind, Slot slot) const;

  /// Origins of the chunks, in world coordinates.
  const std::vector<dvec3>& chunk_origins() const { return chunks_.origins(); }
  Affine world_from_item(Slot slot) const;
  Primitive primitive(Slot slot) const;

  std::size_t memory_bytes() const;

 private:
  friend class Access;
  struct Items;  // core/internal/snapshot_copies.h
  Snapshot() = default;
  Snapshot(const Snapshot& like, Items&& items, int threads);
  std::vector<Slot> apply(const Items& items);
  static constexpr std::uint32_t kRankStride = 64;
  /// A record that gets a new slot, and its chunk; kNone when it has no chunk yet.
  struct Newcomer {
    std::uint32_t record, chunk;
  };
  /// Rows of the scene's materials, and from first_override_row on, unless that is 0, those of overrides.
  struct Table {
    MaterialTable rows;
    std::size_t of_scene = 0, first_override_row = 0;
    void move_override_rows();
  };
  class SceneItems;
  class CopiedItems;
  /// Source: one of the two.
  template <class Source>
  void build(const Source& source, int threads);
  template <class Source>
  Aabb write(const Source& source, std::span<const std::uint32_t> order, const LargeArray<Aabb>& boxes,
             std::size_t first, std::size_t end, LargeArray<dvec3>& places);
  void make_room(bool with_layers);
  static float size_of(const Aabb& box);
  static std::shared_ptr<Table> updated(const Table& former, const Scene& scene,
                                        std::span<const std::uint32_t> materials);
  static AabbD gather(const Scene& scene, const Scene::ItemState& state, ItemId item, Items& out);
  void stay_or_go(const Items& items, std::span<const std::uint64_t> known, std::vector<Slot>& touched,
                  std::vector<Newcomer>& appended);
  void prefetch_ahead(std::span<const std::uint64_t> known, std::size_t at) const;
  void append_sorted(const Items& items, std::span<const Newcomer> newcomers);
  void append(const Items& items, std::uint32_t record, std::uint32_t chunk);
  void give_up(Slot slot);
  void show(Slot slot, const Aabb& box, std::uint32_t layers);
  Placement& placement(Slot slot) { return kind_items_[std::size_t(kinds_[slot])].placements[index_in_kind_[slot]]; }
  Placement place(const mat3& linear, const dvec3& origin, std::uint32_t chunk) const;
  void extend_ranks();
  void count_vacant();
  std::uint32_t vacant_below(Slot slot) const;
  Slot first_where(bool vacant, Slot first, Slot end) const;

  const Scene* scene_ = nullptr;
  std::uint64_t generation_ = 0;
  ItemBounds bounds_;
  std::size_t ordered_size_ = 0, given_up_ = 0;
  LargeArray<Kind> kinds_;
  LargeArray<std::uint32_t> index_in_kind_;
  LargeArray<ItemId> items_;
  LargeArray<Slot> slots_;
  LargeArray<std::uint32_t> materials_;
  std::array<KindItems, kKindCount> kind_items_;
  LargeArray<std::array<std::uint32_t, kKindCount>> ranks_;  // per 64 slots: number of items of each kind before
  LargeArray<float> block_sizes_;                            // per 32 slots: width + depth + height when ordered
  LargeArray<std::uint64_t> vacant_;                         // a bit per slot; empty while no slot is vacant
  LargeArray<std::uint32_t> vacant_before_;                  // per 64 slots and at the end; empty while none is
  ChunkGrid chunks_;
  std::shared_ptr<const void> stored_;                        // with it in a scene cache; null once it is changed
  std::shared_ptr<Table> table_ = std::make_shared<Table>();  // shared with Items: not changed while it is
  MeshList meshes_;
};

}  // namespace sightline::core
