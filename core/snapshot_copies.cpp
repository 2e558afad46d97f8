#include "sightline/core/internal/snapshot_copies.h"

#include <cassert>

namespace sightline::core {

void Snapshot::Items::append(const Items& other) {
  const std::size_t first = records.size();
  const std::uint32_t offset = std::uint32_t(parameters.size());
  records.insert(records.end(), other.records.begin(), other.records.end());
  for (std::size_t i = first; i < records.size(); ++i)
    if (int(records[i].kind) < kPrimitiveKindCount) records[i].payload += offset;
  parameters.insert(parameters.end(), other.parameters.begin(), other.parameters.end());
  removed.insert(removed.end(), other.removed.begin(), other.removed.end());
  if (other.materials) materials = other.materials;
  if (other.meshes.size() >= meshes.size()) meshes = other.meshes;
}

void copy_items(const Snapshot& snapshot, Slot first, Slot end, ItemCopies& out) {
  assert(first <= end && end <= snapshot.size());
  const auto in = Access::of(snapshot);
  out.materials = in.table();
  out.meshes = in.meshes();
  for (Slot s = first; s < end; ++s) {
    if (snapshot.item(s) == kNoItem) continue;
    const KindItems& list = snapshot.of_kind(snapshot.kind(s));
    const std::size_t i = snapshot.index_in_kind(s);
    ItemCopies::Record r;
    r.item = snapshot.item(s);
    r.kind = snapshot.kind(s);
    r.layers = snapshot.vacant(s) ? 0 : snapshot.bounds().layers(s);
    r.material = snapshot.material(s);
    r.box = snapshot.bounds().box(s);
    r.linear = list.placements[i].linear;
    r.origin = snapshot.world_from_item(s).origin;
    if (int(r.kind) < kPrimitiveKindCount) {
      r.payload = std::uint32_t(out.parameters.size());
      const auto count = std::ptrdiff_t(parameter_count(r.kind));
      const auto values = list.parameters.begin() + std::ptrdiff_t(i) * count;
      out.parameters.insert(out.parameters.end(), values, values + count);
    } else {
      r.payload = list.meshes[i];
    }
    out.records.push_back(r);
  }
}

void copy_items(const Snapshot& snapshot, std::span<const ItemId> items, ItemCopies& out) {
  out.materials = Access::of(snapshot).table();
  out.meshes = Access::of(snapshot).meshes();
  for (const ItemId item : items) {
    const Slot s = snapshot.slot(item);
    if (s == kNone)
      out.removed.push_back(item);
    else
      copy_items(snapshot, s, s + 1, out);
  }
}

}  // namespace sightline::core
