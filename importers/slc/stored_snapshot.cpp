#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include "sightline/importers/slc/internal/storage.h"
#include "sightline/importers/slc/internal/storage_checks.h"

namespace sightline::importers::storage {

using core::Aabb;
using core::Access;
using core::dvec3;
using core::Expected;
using core::fail;
using core::ItemBounds;
using core::ItemId;
using core::kBlockSlots;
using core::Kind;
using core::KindItems;
using core::kKindCount;
using core::kNoItem;
using core::kNone;
using core::kPrimitiveKindCount;
using core::LargeArray;
using core::MeshId;
using core::Page;
using core::Placement;
using core::Scene;
using core::Slot;
using core::Snapshot;
using gpuprims::StoredJoints;

namespace {

bool is_number(float x) {
  return std::isfinite(x);
}

/// Whether nothing in them leads outside of arrays.
bool are_safe(const StoredJoints& joints, std::size_t item_slots) {
  const auto& first = joints.first;
  return joints.bits.size() <= item_slots / 32 + 1 && first.size() <= item_slots / 32 + 2 &&
         (first.empty() ? joints.covers.empty() : first.back() == joints.covers.size()) &&
         std::is_sorted(first.begin(), first.end());
}

bool has_right_sizes(const Scene& scene, const Snapshot& snapshot) {
  const auto in = Access::of(snapshot);
  const auto bounds = Access::of(in.bounds());
  const std::size_t n = in.kinds().size(), words = n / 64 + 1;
  bool sizes = in.index_in_kind().size() == n && in.items().size() == n && in.materials().size() == n &&
               in.slots().size() == scene.item_slots() && n == scene.item_count() &&
               (bounds.layers().empty() || bounds.layers().size() == n) &&
               in.block_sizes().size() == (n + kBlockSlots - 1) / kBlockSlots && in.ranks().size() == n / 64 + 1 &&
               (in.vacant().empty() ? in.vacant_before().empty()
                                    : in.vacant().size() == words && in.vacant_before().size() == words + 1);
  for (const auto& c : bounds.coordinates()) sizes &= c.size() == n + ItemBounds::kPadding || (n == 0 && c.empty());
  std::size_t members = 0;
  for (std::size_t k = 0; k < in.kind_items().size(); ++k) {
    const KindItems& kind = in.kind_items()[k];
    const bool primitive = int(k) < kPrimitiveKindCount;
    const std::size_t values = primitive ? std::size_t(core::parameter_count(Kind(k))) : 0;
    sizes &= kind.placements.size() == kind.members.size() && kind.parameters.size() == kind.members.size() * values &&
             kind.meshes.size() == (primitive ? 0 : kind.members.size());
    members += kind.members.size();
  }
  return sizes && members == n;
}

/// Whether the box of a slot is finite, within the extent, and empty exactly where the slot is vacant.
bool box_holds(const Snapshot& snapshot, std::size_t s) {
  const auto in = Access::of(snapshot);
  const ItemBounds& bounds = in.bounds();
  const auto arrays = Access::of(bounds);
  for (int axis = 0; axis < 6; ++axis)
    if (!is_number(arrays.coordinates()[axis][s])) return false;
  const bool vacant = !in.vacant().empty() && (in.vacant()[s / 64] >> s % 64 & 1) != 0;
  if (vacant != bounds.vacant(s) || (!arrays.layers().empty() && arrays.layers()[s] == 0)) return false;
  if (vacant) return true;
  const Aabb box = bounds.box(s);
  return !box.empty() && glm::all(glm::lessThanEqual(bounds.extent().min, box.min)) &&
         glm::all(glm::lessThanEqual(box.max, bounds.extent().max));
}

/// Slots and items, which name each other. Slots are far from the order of items: a byte for each item takes less of
/// the cache than the items.
Expected<void> check_slots(const Scene& scene, const Snapshot& snapshot) {
  const auto of_scene = Access::of(scene);
  const auto in = Access::of(snapshot);
  const std::size_t n = in.kinds().size(), chunks = in.chunks().origins().size();
  constexpr std::uint8_t kGone = 255;
  std::vector<std::uint8_t> kinds(of_scene.items().size());
  for (std::size_t i = 0; i < kinds.size(); ++i)
    kinds[i] = of_scene.items()[i].alive ? std::uint8_t(of_scene.items()[i].kind) : kGone;
  const auto holds = [&](std::size_t s) {
    const Kind kind = in.kinds()[s];
    if (std::uint8_t(kind) >= kKindCount) return false;
    const KindItems& list = in.kind_items()[std::size_t(kind)];
    const std::size_t i = in.index_in_kind()[s];
    const ItemId item = in.items()[s];
    if (i >= list.members.size() || list.members[i] != s || to_index(item) >= in.slots().size() ||
        in.slots()[to_index(item)] != s || kinds[to_index(item)] != std::uint8_t(kind))
      return false;
    if (list.placements[i].chunk >= chunks) return false;
    if (int(kind) >= kPrimitiveKindCount && list.meshes[i] != of_scene.items()[to_index(item)].payload) return false;
    const std::uint32_t material = in.materials()[s];
    if (material != kNone && material >= scene.material_slots()) return false;
    return box_holds(snapshot, s);
  };
  if (const std::size_t wrong = first_wrong(n, holds); wrong < n) return inconsistent("slot", wrong);
  for (const auto& c : Access::of(in.bounds()).coordinates())
    for (std::size_t i = n; i < c.size(); ++i)
      if (std::abs(c[i]) != Aabb::kFar) return fail("the padding of its bounds is inconsistent");
  const auto item_holds = [&](std::size_t item) {
    return kinds[item] != kGone ? in.slots()[item] < n : in.slots()[item] == kNone;
  };
  if (const std::size_t wrong = first_wrong(scene.item_slots(), item_holds); wrong < scene.item_slots())
    return inconsistent("slot of item", wrong);
  return {};
}

/// Checks the prefix counts: of items of each kind, and of vacant slots.
Expected<void> check_counts(const Snapshot& snapshot) {
  const auto in = Access::of(snapshot);
  const std::size_t n = in.kinds().size(), words = n / 64 + 1;
  const bool any_vacant = !in.vacant().empty();
  std::array<std::uint32_t, kKindCount> rank{};
  std::uint32_t vacant = 0;
  for (std::size_t word = 0; word < words; ++word) {
    if (in.ranks()[word] != rank) return inconsistent("rank", word);
    if (any_vacant) {
      std::uint64_t bits = in.vacant()[word];
      if (word + 1 == words && bits >> n % 64 != 0) return inconsistent("word of vacant slots", word);
      if (in.vacant_before()[word] != vacant) return inconsistent("count of vacant slots", word);
      for (; bits != 0; bits &= bits - 1) ++vacant;
    }
    for (std::size_t s = word * 64; s < std::min(n, (word + 1) * 64); ++s) ++rank[std::size_t(in.kinds()[s])];
  }
  if (any_vacant && in.vacant_before()[words] != vacant) return inconsistent("count of vacant slots", words);
  return {};
}

Expected<void> check_kinds(const Snapshot& snapshot) {
  const auto in = Access::of(snapshot);
  // Within a kind, members rise with the slots: rank() counts on it.
  for (const KindItems& kind : in.kind_items()) {
    const auto& slots = kind.members;
    if (first_wrong(slots.size(), [&](std::size_t i) { return i == 0 || slots[i - 1] < slots[i]; }) < slots.size())
      return fail("the slots of a kind in its snapshot do not rise");
    const auto finite = [&](std::size_t i) {
      const Placement& p = kind.placements[i];
      for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r)
          if (!is_number(p.linear[c][r])) return false;
      return is_number(p.origin.x) && is_number(p.origin.y) && is_number(p.origin.z);
    };
    if (first_wrong(kind.placements.size(), finite) < kind.placements.size())
      return fail("a placement in its snapshot is not finite");
  }
  return {};
}

Expected<void> check(const Scene& scene, const Snapshot& snapshot) {
  const auto in = Access::of(snapshot);
  if (!has_right_sizes(scene, snapshot)) return fail("the arrays of its snapshot have different sizes");
  if (const StoredJoints* joints = gpuprims::stored_joints(snapshot); joints && !are_safe(*joints, scene.item_slots()))
    return fail("the joints of its snapshot are inconsistent");
  for (const dvec3& origin : in.chunks().origins())
    if (!core::is_finite(origin)) return fail("the chunks of its snapshot are not finite");
  if (!core::is_finite(in.bounds().origin) || !(in.chunks().size() >= 0.0))
    return fail("the origin of its snapshot is not finite");
  if (auto good = check_slots(scene, snapshot); !good) return good;
  if (auto good = check_counts(snapshot); !good) return good;
  return check_kinds(snapshot);
}

bool all_finite(const float* values, std::size_t count) {
  return std::all_of(values, values + count, [](float x) { return std::isfinite(x); });
}

bool placement_is_finite(const Placement& p) {
  return all_finite(&p.linear[0].x, 9) && all_finite(&p.origin.x, 3);
}

/// Fills in what follows from the kinds of slots: index, members, ranks, vacant slots.
Expected<void> count_kinds(Snapshot& snapshot) {
  const auto in = Access::of(snapshot);
  const std::size_t n = in.kinds().size();
  std::array<std::uint32_t, kKindCount> rank{};
  for (std::size_t s = 0; s < n; ++s) {
    if (s % 64 == 0) in.ranks()[s / 64] = rank;
    const auto kind = std::size_t(in.kinds()[s]);
    if (kind >= kKindCount || rank[kind] >= in.kind_items()[kind].members.size())
      return fail("its kinds of items are inconsistent");
    in.index_in_kind()[s] = rank[kind];
    in.kind_items()[kind].members[rank[kind]++] = Slot(s);
    if (!in.bounds().vacant(s)) continue;
    in.vacant().resize(n / 64 + 1);
    in.vacant()[s / 64] |= std::uint64_t(1) << s % 64;
  }
  if (n % 64 == 0) in.ranks()[n / 64] = rank;
  in.count_vacant();
  return {};
}

Expected<void> check_page(const Page& page) {
  const Snapshot& snapshot = page.snapshot;
  const auto in = Access::of(snapshot);
  const ItemBounds& bounds = in.bounds();
  const auto arrays = Access::of(bounds);
  const std::size_t rows = in.table()->rows.size(), chunks = in.chunks().origins().size();
  for (const auto& c : arrays.coordinates())
    if (!all_finite(c.data(), c.size())) return fail("its boxes are not finite");
  for (std::size_t s = 0; s < snapshot.size(); ++s) {
    if (in.materials()[s] != kNone && in.materials()[s] >= rows) return fail("its materials are inconsistent");
    if (in.items()[s] == kNoItem) return fail("its items are inconsistent");
    if (bounds.uses_layers() && arrays.layers()[s] == 0) return fail("its layers are inconsistent");
  }
  for (const dvec3& origin : in.chunks().origins())
    if (!core::is_finite(origin)) return fail("its chunks are not finite");
  for (std::size_t kind = 0; kind < kKindCount; ++kind) {
    const KindItems& items = in.kind_items()[kind];
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

}  // namespace

SnapshotState state(const Snapshot& snapshot) {
  const core::ChunkGrid& chunks = Access::of(snapshot).chunks();
  return {snapshot.bounds().origin, snapshot.bounds().extent(), chunks.size(), chunks.origins()};
}

void set_state(Snapshot& snapshot, SnapshotState state, std::shared_ptr<const StoredJoints> joints) {
  const auto in = Access::of(snapshot);
  const auto bounds = Access::of(in.bounds());
  in.stored() = std::move(joints);
  in.bounds().origin = state.origin;
  bounds.extent() = state.extent;
  bounds.size() = in.kinds().size();
  bounds.uses_layers() = !bounds.layers().empty();
  in.ordered_size() = in.kinds().size();
  in.chunks() = core::ChunkGrid::restored(state.chunk_size, std::move(state.chunk_origins));
}

Expected<void> try_snapshot(const Scene& scene, const std::function<bool(Snapshot&)>& fill) {
  Snapshot snapshot = Access::empty_snapshot();
  Access::of(snapshot).scene() = &scene;
  Access::of(snapshot).meshes() = Access::of(scene).mesh_table().list();
  if (!fill(snapshot)) return fail("the arrays of its snapshot have elements of another size");
  return check(scene, snapshot);
}

Expected<void> finish_page(Page& page, SnapshotState state, const Snapshot& materials) {
  static std::atomic<std::uint64_t> generations{std::uint64_t(1) << 63};  // apart from those of whole snapshots
  Snapshot& snapshot = page.snapshot;
  const auto in = Access::of(snapshot);
  in.generation() = ++generations;
  in.table() = Access::of(materials).table();
  in.meshes() = Access::of(page.meshes).mesh_table().list();
  set_state(snapshot, std::move(state), nullptr);
  for (int axis = 0; axis < 6; ++axis) {
    LargeArray<float>& c = Access::of(in.bounds()).coordinates()[axis];
    std::fill(c.end() - std::ptrdiff_t(ItemBounds::kPadding), c.end(), axis < 3 ? Aabb::kFar : -Aabb::kFar);
  }
  if (auto good = count_kinds(snapshot); !good) return good;
  return check_page(page);
}

}  // namespace sightline::importers::storage
