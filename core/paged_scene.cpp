#include "sightline/core/paged_scene.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <string>

#include "sightline/core/internal/storage.h"

namespace sightline::core {
namespace {

bool all_finite(const float* values, std::size_t count) {
  return std::all_of(values, values + count, [](float x) { return std::isfinite(x); });
}

bool placement_is_finite(const Placement& p) {
  return all_finite(&p.linear[0].x, 9) && all_finite(&p.origin.x, 3);
}

}  // namespace

void Page::drop_records() {
  Storage::drop_records(snapshot);
}

void Storage::drop_records(Snapshot& snapshot) {
  for (int kind = 0; kind < kPrimitiveKindCount; ++kind) {
    snapshot.kind_items_[std::size_t(kind)].placements = {};
    snapshot.kind_items_[std::size_t(kind)].parameters = {};
  }
}

Expected<void> Storage::finish_page(Page& page, SnapshotState state, const Snapshot& materials) {
  static std::atomic<std::uint64_t> generations{std::uint64_t(1) << 63};  // apart from those of whole snapshots
  Snapshot& snapshot = page.snapshot;
  snapshot.generation_ = ++generations;
  snapshot.table_ = materials.table_;
  snapshot.meshes_ = page.meshes.mesh_table_.list();
  set_state(snapshot, std::move(state), nullptr);
  for (int axis = 0; axis < 6; ++axis) {
    LargeArray<float>& c = snapshot.bounds_.coordinates_[axis];
    std::fill(c.end() - std::ptrdiff_t(ItemBounds::kPadding), c.end(), axis < 3 ? Aabb::kFar : -Aabb::kFar);
  }
  if (auto good = count_kinds(snapshot); !good) return good;
  return check_page(page);
}

/// Fills in what follows from the kinds of slots: index, members, ranks, vacant slots.
Expected<void> Storage::count_kinds(Snapshot& snapshot) {
  const std::size_t n = snapshot.kinds_.size();
  std::array<std::uint32_t, kKindCount> rank{};
  for (std::size_t s = 0; s < n; ++s) {
    if (s % 64 == 0) snapshot.ranks_[s / 64] = rank;
    const auto kind = std::size_t(snapshot.kinds_[s]);
    if (kind >= kKindCount || rank[kind] >= snapshot.kind_items_[kind].members.size())
      return fail("its kinds of items are inconsistent");
    snapshot.index_in_kind_[s] = rank[kind];
    snapshot.kind_items_[kind].members[rank[kind]++] = Slot(s);
    if (!snapshot.bounds_.vacant(s)) continue;
    snapshot.vacant_.resize(n / 64 + 1);
    snapshot.vacant_[s / 64] |= std::uint64_t(1) << s % 64;
  }
  if (n % 64 == 0) snapshot.ranks_[n / 64] = rank;
  snapshot.count_vacant();
  return {};
}

Expected<void> Storage::check_page(const Page& page) {
  const Snapshot& snapshot = page.snapshot;
  const ItemBounds& bounds = snapshot.bounds_;
  const std::size_t rows = snapshot.table_->rows.size(), chunks = snapshot.chunks_.origins().size();
  for (const auto& c : bounds.coordinates_)
    if (!all_finite(c.data(), c.size())) return fail("its boxes are not finite");
  for (std::size_t s = 0; s < snapshot.size(); ++s) {
    if (snapshot.materials_[s] != kNone && snapshot.materials_[s] >= rows)
      return fail("its materials are inconsistent");
    if (snapshot.items_[s] == kNone) return fail("its items are inconsistent");
    if (bounds.uses_layers() && bounds.layers_[s] == 0) return fail("its layers are inconsistent");
  }
  for (const dvec3& origin : snapshot.chunks_.origins())
    if (!is_finite(dvec3(origin))) return fail("its chunks are not finite");
  for (std::size_t kind = 0; kind < kKindCount; ++kind) {
    const KindItems& items = snapshot.kind_items_[kind];
    for (const Placement& p : items.placements)
      if (p.chunk >= chunks || !placement_is_finite(p)) return fail("its placements are inconsistent");
    for (const std::uint32_t mesh : items.meshes) {
      const MeshId id = mesh < page.meshes.mesh_slots() ? page.meshes.mesh_at(mesh) : MeshId();
      if (!id.valid() || page.meshes.mesh(id).is_facet_group() != (Kind(kind) == Kind::kFacetGroup))
        return fail("its meshes are inconsistent");
    }
  }
  return {};
}

}  // namespace sightline::core
