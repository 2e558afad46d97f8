// The arrays of scenes and snapshots, for the scene cache, which writes them to a file and maps them from it.
//
// An array is stored as it lies in memory. layout() changes with anything that another build of the library would lay
// out otherwise. What comes from a file is checked before anyone may use it: afterwards any scene or snapshot is safe
// to use, whatever the file said.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>

#include "sightline/core/api.h"
#include "sightline/core/error.h"
#include "sightline/core/paged_scene.h"
#include "sightline/core/scene.h"
#include "sightline/core/snapshot.h"

namespace sightline::core {

class SIGHTLINE_API Storage {
 public:
  /// A number for how this build lays out the arrays.
  static std::uint64_t layout();

  /// Numbers of arrays. Those of a kind k follow at kKindArrays + 4 k: members, placements, parameters, meshes.
  enum SceneArray : std::uint64_t { kNodes = 1, kItems, kParameters, kNames, kFreeNodes };
  enum SnapshotArray : std::uint64_t {
    kCoordinates = 100,
    kLayers = 106,
    kKinds,
    kIndexInKind,
    kSlotItems,
    kItemSlots,
    kSlotMaterials,
    kRanks,
    kBlockSizes,
    kVacant,
    kVacantBefore,
    kKindArrays = 200,
  };

  /// visit(number, array) for all arrays. `scene` and `snapshot` may be const.
  template <class S, class Visit>
  static void for_each_scene_array(S& scene, Visit&& visit) {
    visit(std::uint64_t(kNodes), scene.nodes_);
    visit(std::uint64_t(kItems), scene.items_);
    visit(std::uint64_t(kParameters), scene.parameters_);
    visit(std::uint64_t(kNames), scene.names_);
    visit(std::uint64_t(kFreeNodes), scene.free_nodes_);
  }
  template <class S, class Visit>
  static void for_each_snapshot_array(S& snapshot, Visit&& visit) {
    for (std::uint64_t axis = 0; axis < 6; ++axis) visit(kCoordinates + axis, snapshot.bounds_.coordinates_[axis]);
    visit(std::uint64_t(kLayers), snapshot.bounds_.layers_);
    visit(std::uint64_t(kKinds), snapshot.kinds_);
    visit(std::uint64_t(kIndexInKind), snapshot.index_in_kind_);
    visit(std::uint64_t(kSlotItems), snapshot.items_);
    visit(std::uint64_t(kItemSlots), snapshot.slots_);
    visit(std::uint64_t(kSlotMaterials), snapshot.materials_);
    visit(std::uint64_t(kRanks), snapshot.ranks_);
    visit(std::uint64_t(kBlockSizes), snapshot.block_sizes_);
    visit(std::uint64_t(kVacant), snapshot.vacant_);
    visit(std::uint64_t(kVacantBefore), snapshot.vacant_before_);
    for (std::uint64_t kind = 0; kind < snapshot.kind_items_.size(); ++kind) {
      auto& items = snapshot.kind_items_[kind];
      const std::uint64_t first = kKindArrays + 4 * kind;
      visit(first, items.members);
      visit(first + 1, items.placements);
      visit(first + 2, items.parameters);
      visit(first + 3, items.meshes);
    }
  }

  /// Copies values with zeros for the bytes between members, and without what only the running program knows.
  template <class T>
  static void copy_clean(const T* values, std::size_t count, std::byte* to) {
    if (count > 0) std::memcpy(to, values, count * sizeof(T));
  }
  static void copy_clean(const Scene::Node* values, std::size_t count, std::byte* to);
  static void copy_clean(const Scene::Item* values, std::size_t count, std::byte* to);

  /// What a snapshot holds beside its arrays.
  struct SnapshotState {
    dvec3 origin{0.0};
    Aabb extent;
    double chunk_size = 0.0;
    std::vector<dvec3> chunk_origins;
  };
  static SnapshotState state(const Snapshot& snapshot);
  /// `snapshot` must have its arrays. No `joints`: they are unknown.
  static void set_state(Snapshot& snapshot, SnapshotState state, std::shared_ptr<const StoredJoints> joints);

  /// Appends the place of a mesh or material that was removed.
  static void add_removed_mesh(Scene& scene);
  static void add_removed_material(Scene& scene);
  /// Attributes of nodes, in rising order of nodes.
  static StoredAttributes attributes(const Scene& scene);

  /// Checks a scene whose arrays, meshes and materials were read, and makes it as it is after an import: nothing is
  /// committed. The root must have no items.
  static Expected<void> finish(Scene& scene, std::shared_ptr<const StoredAttributes> attributes);
  /// Items of which it is not known that commit() would accept them.
  static std::vector<ItemId> not_surely_fit(const Scene& scene);
  /// A snapshot of the scene that `fill` makes what it should be, checked.
  static Expected<void> try_snapshot(const Scene& scene, const std::function<bool(Snapshot&)>& fill);
  /// From now on Snapshot(scene) asks `source`, which makes a new snapshot what would be built, until the scene is
  /// edited. Where it returns false, the snapshot is built.
  static void set_snapshot(Scene& scene, std::function<bool(Snapshot&)> source);
  static bool has_snapshot(const Scene& scene) { return scene.stored_snapshot_ != nullptr; }

  /// What is read of a page's snapshot, beside what it has by kind but for members. The other arrays follow from these.
  static constexpr std::uint64_t kPageArrays[] = {
      kCoordinates,     kCoordinates + 1, kCoordinates + 2, kCoordinates + 3, kCoordinates + 4,
      kCoordinates + 5, kLayers,          kKinds,           kSlotItems,       kSlotMaterials};
  /// Makes a page's snapshot whole, which must have arrays of the right sizes. Those named above hold what was read,
  /// but for the padding of coordinates; members, kIndexInKind and kRanks hold anything. `materials`: the snapshot
  /// whose table it shares. Fails on what would not be safe to use.
  static Expected<void> finish_page(Page& page, SnapshotState state, const Snapshot& materials);
  static void drop_records(Snapshot& snapshot);

 private:
  static Expected<void> check_nodes(const Scene& scene);
  static Expected<void> check_items(const Scene& scene);
  static bool is_one_tree(const Scene& scene);
  static Expected<void> check(const Scene& scene, const Snapshot& snapshot);
  static Expected<void> count_kinds(Snapshot& snapshot);
  static Expected<void> check_page(const Page& page);
  static bool are_safe(const StoredJoints& joints, std::size_t item_slots);
  static void mark_fit(Scene& scene);
};

}  // namespace sightline::core
