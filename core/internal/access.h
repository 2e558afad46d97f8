// The private parts of scenes and snapshots, for code of the library that does not go through their functions: the
// scene cache (importers/slc) writes their arrays to a file and maps them from it, and a new scene version is built
// from copies of items. Whoever changes a part keeps what the functions of the class rely on.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "sightline/core/item_bounds.h"
#include "sightline/core/scene.h"
#include "sightline/core/snapshot.h"

namespace sightline::core {

/// Access::of(scene).nodes() and the like: references to members, which are const where the object is.
class Access {
 public:
  using Node = Scene::Node;
  using Item = Scene::Item;
  using SnapshotItems = Snapshot::Items;
  static constexpr std::uint8_t kDirty = Scene::kDirty, kFit = Scene::kFit;  ///< bits of item_states()

  template <class S>
  struct SceneParts {
    S& scene;
    auto& nodes() const { return scene.nodes_; }
    auto& items() const { return scene.items_; }
    auto& item_states() const { return scene.item_states_; }
    auto& parameters() const { return scene.parameters_; }
    auto& names() const { return scene.names_; }
    auto& free_nodes() const { return scene.free_nodes_; }
    auto& mesh_table() const { return scene.mesh_table_; }
    auto& meshes() const { return scene.meshes_; }
    auto& materials() const { return scene.materials_; }
    auto& attributes() const { return scene.attributes_; }
    auto& stored_attributes() const { return scene.stored_attributes_; }
    auto& stored_snapshot() const { return scene.stored_snapshot_; }
    auto& dirty_items() const { return scene.dirty_items_; }
    auto& dirty_materials() const { return scene.dirty_materials_; }
    auto& live_nodes() const { return scene.live_nodes_; }
    auto& live_items() const { return scene.live_items_; }
    NodeId handle(std::uint32_t node) const { return scene.handle(node); }
  };
  static SceneParts<Scene> of(Scene& scene) { return {scene}; }
  static SceneParts<const Scene> of(const Scene& scene) { return {scene}; }

  template <class B>
  struct BoundsParts {
    B& bounds;
    auto& coordinates() const { return bounds.coordinates_; }
    auto& layers() const { return bounds.layers_; }
    auto& size() const { return bounds.size_; }
    auto& extent() const { return bounds.extent_; }
    auto& uses_layers() const { return bounds.uses_layers_; }
  };
  static BoundsParts<ItemBounds> of(ItemBounds& bounds) { return {bounds}; }
  static BoundsParts<const ItemBounds> of(const ItemBounds& bounds) { return {bounds}; }

  template <class S>
  struct SnapshotParts {
    S& snapshot;
    auto& scene() const { return snapshot.scene_; }
    auto& generation() const { return snapshot.generation_; }
    auto& bounds() const { return snapshot.bounds_; }
    auto& ordered_size() const { return snapshot.ordered_size_; }
    auto& kinds() const { return snapshot.kinds_; }
    auto& index_in_kind() const { return snapshot.index_in_kind_; }
    auto& items() const { return snapshot.items_; }
    auto& slots() const { return snapshot.slots_; }
    auto& materials() const { return snapshot.materials_; }
    auto& kind_items() const { return snapshot.kind_items_; }
    auto& ranks() const { return snapshot.ranks_; }
    auto& block_sizes() const { return snapshot.block_sizes_; }
    auto& vacant() const { return snapshot.vacant_; }
    auto& vacant_before() const { return snapshot.vacant_before_; }
    auto& chunks() const { return snapshot.chunks_; }
    /// gpuprims::StoredJoints, of which core knows nothing. Null: unknown, or the snapshot was changed since it came
    /// from a scene cache.
    auto& stored() const { return snapshot.stored_; }
    auto& table() const { return snapshot.table_; }
    auto& meshes() const { return snapshot.meshes_; }
    void count_vacant() const { snapshot.count_vacant(); }
    std::vector<Slot> apply(const SnapshotItems& items) const { return snapshot.apply(items); }
  };
  static SnapshotParts<Snapshot> of(Snapshot& snapshot) { return {snapshot}; }
  static SnapshotParts<const Snapshot> of(const Snapshot& snapshot) { return {snapshot}; }

  /// Scene::commit() of so many items at most, removed ones first, for consumers that must not stop. Removed meshes go
  /// with the last of them. Where an item is refused, nothing of this call is published.
  SIGHTLINE_API static Expected<SceneDelta> publish(Scene& scene, std::size_t most);
  /// Whether publish() has anything left to do.
  static bool has_edits(const Scene& scene) {
    return !scene.dirty_nodes_.empty() || !scene.dirty_items_.empty() || !scene.removed_items_.empty() ||
           !scene.dirty_materials_.empty() || !scene.removed_meshes_.empty() || !scene.removed_materials_.empty();
  }

  static Snapshot empty_snapshot() { return {}; }
  static Snapshot reordered(const Snapshot& like, SnapshotItems&& items, int threads) {
    return {like, std::move(items), threads};
  }

 private:
  static std::vector<ItemId> touched_items(Scene& scene);
  static void touch_items_below(Scene& scene, std::size_t wanted);
  static void announce(Scene& scene, const SceneDelta& delta);
};

}  // namespace sightline::core
