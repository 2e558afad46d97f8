// Copies of a snapshot's items, for a new scene version that is built in the background.
//
// The scene is not read, so it may be edited meanwhile. First copy all slots piece by piece, then build with
// reordered(), then copy and apply the items that were edited since the first piece.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "sightline/core/internal/access.h"

namespace sightline::core {

/// Copies of items, in no order.
struct Snapshot::Items {
  struct Record {
    ItemId item = kNoItem;
    Kind kind = Kind::kMesh;
    std::uint32_t layers = 0;  // 0: hidden
    std::uint32_t material = kNone;
    std::uint32_t payload = 0;  // mesh index, or first of `parameters`
    Aabb box;                   // relative to the origin of the bounds
    mat3 linear{1.0f};
    dvec3 origin{0.0};  // in the world
  };
  std::vector<Record> records;
  std::vector<float> parameters;
  std::vector<ItemId> removed;
  std::shared_ptr<Table> materials;  // null: unchanged
  MeshList meshes;

  void append(const Items& other);
};
using ItemCopies = Access::SnapshotItems;

void copy_items(const Snapshot& snapshot, Slot first, Slot end, ItemCopies& out);
/// Items that are gone go to ItemCopies::removed.
void copy_items(const Snapshot& snapshot, std::span<const ItemId> items, ItemCopies& out);

/// Builds a new scene version from copies. When an item was copied twice because it changed its slot meanwhile, the
/// later copy counts. The scene and the origin of the bounds are those of `like`; nothing else of it is read, since
/// only these never change.
inline Snapshot reordered(const Snapshot& like, ItemCopies&& items, int threads = 0) {
  return Access::reordered(like, std::move(items), threads);
}

/// Makes the snapshot show its items as the copies do. Returns what Snapshot::apply() returns.
inline std::vector<Slot> apply_copies(Snapshot& snapshot, const ItemCopies& items) {
  return Access::of(snapshot).apply(items);
}

}  // namespace sightline::core
