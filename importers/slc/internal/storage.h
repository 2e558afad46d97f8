// The arrays of scenes and snapshots, for the scene cache, which writes them to a file and maps them from it. Internal
// to the importers.
//
// An array is stored as it lies in memory. layout() changes with anything that another build of the library would lay
// out otherwise. What comes from a file is checked before anyone may use it: afterwards any scene or snapshot is safe
// to use, whatever the file said.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <memory>
#include <vector>

#include "sightline/core/error.h"
#include "sightline/core/internal/access.h"
#include "sightline/core/internal/stored_attributes.h"
#include "sightline/core/paged_scene.h"
#include "sightline/gpuprims/internal/joints.h"

namespace sightline::importers::storage {

/// A number for how this build lays out the arrays.
std::uint64_t layout();

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
void for_each_scene_array(S& scene, Visit&& visit) {
  const auto in = core::Access::of(scene);
  visit(std::uint64_t(kNodes), in.nodes());
  visit(std::uint64_t(kItems), in.items());
  visit(std::uint64_t(kParameters), in.parameters());
  visit(std::uint64_t(kNames), in.names());
  visit(std::uint64_t(kFreeNodes), in.free_nodes());
}
template <class S, class Visit>
void for_each_snapshot_array(S& snapshot, Visit&& visit) {
  const auto in = core::Access::of(snapshot);
  const auto bounds = core::Access::of(in.bounds());
  for (std::uint64_t axis = 0; axis < 6; ++axis) visit(kCoordinates + axis, bounds.coordinates()[axis]);
  visit(std::uint64_t(kLayers), bounds.layers());
  visit(std::uint64_t(kKinds), in.kinds());
  visit(std::uint64_t(kIndexInKind), in.index_in_kind());
  visit(std::uint64_t(kSlotItems), in.items());
  visit(std::uint64_t(kItemSlots), in.slots());
  visit(std::uint64_t(kSlotMaterials), in.materials());
  visit(std::uint64_t(kRanks), in.ranks());
  visit(std::uint64_t(kBlockSizes), in.block_sizes());
  visit(std::uint64_t(kVacant), in.vacant());
  visit(std::uint64_t(kVacantBefore), in.vacant_before());
  for (std::uint64_t kind = 0; kind < in.kind_items().size(); ++kind) {
    auto& items = in.kind_items()[kind];
    const std::uint64_t first = kKindArrays + 4 * kind;
    visit(first, items.members);
    visit(first + 1, items.placements);
    visit(first + 2, items.parameters);
    visit(first + 3, items.meshes);
  }
}

/// Copies values with zeros for the bytes between members, and without what only the running program knows.
template <class T>
void copy_clean(const T* values, std::size_t count, std::byte* to) {
  if (count > 0) std::memcpy(to, values, count * sizeof(T));
}
void copy_clean(const core::Access::Node* values, std::size_t count, std::byte* to);
void copy_clean(const core::Access::Item* values, std::size_t count, std::byte* to);

/// The values that a snapshot holds beside its arrays.
struct SnapshotState {
  core::dvec3 origin{0.0};
  core::Aabb extent;
  double chunk_size = 0.0;
  std::vector<core::dvec3> chunk_origins;
};
SnapshotState state(const core::Snapshot& snapshot);
/// `snapshot` must have its arrays. No `joints`: they are unknown.
void set_state(core::Snapshot& snapshot, SnapshotState state, std::shared_ptr<const gpuprims::StoredJoints> joints);

/// Appends the place of a mesh or material that was removed.
void add_removed_mesh(core::Scene& scene);
void add_removed_material(core::Scene& scene);
/// Attributes of nodes, in rising order of nodes.
core::StoredAttributes attributes(const core::Scene& scene);

/// Checks a scene whose arrays, meshes and materials were read, and makes it as it is after an import: nothing is
/// committed. The root must have no items.
core::Expected<void> finish(core::Scene& scene, std::shared_ptr<const core::StoredAttributes> attributes);
/// Items of which it is not known that commit() would accept them.
std::vector<core::ItemId> not_surely_fit(const core::Scene& scene);
/// A snapshot of the scene that `fill` makes what it should be, checked.
core::Expected<void> try_snapshot(const core::Scene& scene, const std::function<bool(core::Snapshot&)>& fill);
/// From now on Snapshot(scene) asks `source`, which makes a new snapshot what would be built, until the scene is
/// edited. Where it returns false, the snapshot is built.
void set_snapshot(core::Scene& scene, std::function<bool(core::Snapshot&)> source);

/// Arrays that are read for a page's snapshot. Those by kind are read, too, but for members. All other arrays follow
/// from these.
inline constexpr std::uint64_t kPageArrays[] = {kCoordinates,     kCoordinates + 1, kCoordinates + 2, kCoordinates + 3,
                                                kCoordinates + 4, kCoordinates + 5, kLayers,          kKinds,
                                                kSlotItems,       kSlotMaterials};
/// Makes a page's snapshot whole, which must have arrays of the right sizes. Those named above hold what was read,
/// but for the padding of coordinates; members, kIndexInKind and kRanks hold anything. `materials`: the snapshot
/// whose table it shares. Fails on what would not be safe to use.
core::Expected<void> finish_page(core::Page& page, SnapshotState state, const core::Snapshot& materials);

}  // namespace sightline::importers::storage
