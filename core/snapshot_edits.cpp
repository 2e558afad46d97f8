#include <algorithm>

#include "sightline/core/block_order.h"
#include "sightline/core/internal/radix_sort.h"
#include "sightline/core/internal/snapshot_copies.h"
#include "sightline/core/internal/snapshot_prefetch.h"

namespace sightline::core {
namespace {

constexpr float kBlockSlack = 1.1f;  // how much larger than its ordered size edits may make a block

/// Union of the boxes of slots first … end - 1, at most a block. Vacant slots do not count.
Aabb union_of(const ItemBounds& bounds, std::size_t first, std::size_t end) {
  constexpr std::size_t kLanes = 8;  // side by side, for vector instructions
  Aabb box;
  for (int axis = 0; axis < 3; ++axis) {
    const float *low = bounds.coordinate(axis), *high = bounds.coordinate(axis + 3);
    float least[kLanes], most[kLanes];
    std::fill_n(least, kLanes, Aabb::kFar);
    std::fill_n(most, kLanes, -Aabb::kFar);
    std::size_t s = first;
    for (; s + kLanes <= end; s += kLanes) {
      for (std::size_t i = 0; i < kLanes; ++i) {
        least[i] = low[s + i] < least[i] ? low[s + i] : least[i];
        most[i] = high[s + i] > most[i] ? high[s + i] : most[i];
      }
    }
    for (; s < end; ++s) {
      least[0] = std::min(least[0], low[s]);
      most[0] = std::max(most[0], high[s]);
    }
    box.min[axis] = *std::min_element(least, least + kLanes);
    box.max[axis] = *std::max_element(most, most + kLanes);
  }
  return box;
}

}  // namespace

std::vector<Slot> Snapshot::apply(const SceneDelta& delta) {
  Items items;
  items.removed = delta.removed;
  // Items may name materials that a later delta publishes.
  if (!delta.materials.empty() || table_->of_scene < scene_->material_slots())
    items.materials = updated(*table_, *scene_, delta.materials);
  items.meshes = scene_->mesh_table_.list();
  items.records.reserve(delta.changed.size() + delta.inserted.size());
  const auto take = [&](ItemId item, const Scene::ItemState& state) {
    const AabbD box = gather(*scene_, state, item, items);
    items.records.back().box = round_outwards(box, bounds_.origin);
  };
  scene_->for_each_state(delta.changed, take);
  scene_->for_each_state(delta.inserted, take);
  return apply(items);
}

std::vector<Slot> Snapshot::apply(const Items& items) {
  stored_.reset();
  if (items.materials) table_ = items.materials;
  if (items.meshes.size() >= meshes_.size()) meshes_ = items.meshes;
  std::vector<Slot> touched;
  touched.reserve(items.removed.size() + items.records.size());
  for (const ItemId item : items.removed) {
    const Slot s = slot(item);
    if (s == kNone) continue;
    give_up(s);
    slots_[to_index(item)] = kNone;
    touched.push_back(s);
  }
  std::vector<std::uint64_t> known;  // slot << 32 | record, to be visited block by block
  std::vector<Newcomer> appended;
  known.reserve(items.records.size());
  for (std::size_t i = 0; i < items.records.size(); ++i) {
    if (i + kPrefetchAhead < items.records.size())
      prefetch(slots_.data() + to_index(items.records[i + kPrefetchAhead].item), sizeof(Slot));
    const Slot s = slot(items.records[i].item);
    if (s != kNone)
      known.push_back(std::uint64_t(s) << 32 | i);
    else
      appended.push_back({std::uint32_t(i), kNone});
  }
  radix_sort<32>(known);
  stay_or_go(items, known, touched, appended);
  append_sorted(items, appended);
  extend_ranks();
  count_vacant();
  return touched;
}

void prefetch_slot(const Snapshot& snapshot, Slot s) {
  const auto in = Access::of(snapshot);
  prefetch(in.kinds()[s]);
  prefetch(in.index_in_kind()[s]);
  prefetch(in.materials()[s]);
  prefetch(in.items()[s]);
}

void prefetch_box(const Snapshot& snapshot, Slot s) {
  const ItemBounds& bounds = snapshot.bounds();
  for (int axis = 0; axis < 6; ++axis) prefetch(bounds.coordinate(axis)[s]);
  if (bounds.uses_layers()) prefetch(bounds.layers()[s]);
}

void prefetch_record(const Snapshot& snapshot, Slot s) {
  const Kind kind = snapshot.kind(s);
  const KindItems& list = snapshot.of_kind(kind);
  const std::size_t i = snapshot.index_in_kind(s);
  prefetch(list.placements[i]);
  if (int(kind) >= kPrimitiveKindCount) return;
  const std::size_t count = std::size_t(parameter_count(kind));
  prefetch(list.parameters.data() + i * count, count * sizeof(float));
}

/// Prefetches a block's boxes and the arrays by slot, and half as far ahead the arrays by kind.
void Snapshot::prefetch_ahead(std::span<const std::uint64_t> known, std::size_t at) const {
  if (at + kPrefetchAhead < known.size()) {
    const std::size_t s = known[at + kPrefetchAhead] >> 32, block = s / kBlockSlots * kBlockSlots;
    for (int axis = 0; axis < 6; ++axis) prefetch(bounds_.coordinate(axis) + block, kBlockSlots * sizeof(float));
    prefetch_slot(*this, Slot(s));
  }
  if (at + kPrefetchAhead / 2 < known.size()) prefetch_record(*this, Slot(known[at + kPrefetchAhead / 2] >> 32));
}

/// Updates known items in their slots, as long as their blocks keep about their sizes. Items that leave their block,
/// and those that have got another mesh, join `appended`, and their slots become vacant.
void Snapshot::stay_or_go(const Items& items, std::span<const std::uint64_t> known, std::vector<Slot>& touched,
                          std::vector<Newcomer>& appended) {
  const auto slot_at = [&](std::size_t i) { return Slot(known[i] >> 32); };
  const auto has_mesh = [&](Slot s, const Items::Record& r) {
    const auto& meshes = kind_items_[std::size_t(r.kind)].meshes;
    return int(r.kind) < kPrimitiveKindCount || meshes[index_in_kind_[s]] == r.payload;
  };
  // Relocation may take up to a quarter more slots. Without a new scene version, further edits make blocks larger
  // instead.
  const std::size_t live = size() - given_up_;
  std::size_t allowance = std::max(live + live / 4 + kBlockSlots, size()) - size();
  std::vector<std::uint32_t> moved_to(chunks_.origins().size(), kNone);  // by chunk: where its last item went
  for (std::size_t first = 0, end = 0; first < known.size(); first = end) {
    const std::size_t block = slot_at(first) / kBlockSlots;
    bool all_stay = true;
    for (end = first; end < known.size() && slot_at(end) / kBlockSlots == block; ++end) {
      prefetch_ahead(known, end);
      const Slot s = slot_at(end);
      const Items::Record& r = items.records[std::uint32_t(known[end])];
      const Aabb old = bounds_.box(s);
      all_stay = all_stay && has_mesh(s, r) && (r.layers == 0 || (old.min == r.box.min && old.max == r.box.max));
      touched.push_back(s);
    }
    Aabb taken;
    if (!all_stay) {
      for (std::size_t i = first; i < end; ++i) bounds_.set(slot_at(i), {});
      taken = union_of(bounds_, block * kBlockSlots, std::min((block + 1) * kBlockSlots, size()));
    }
    for (std::size_t i = first; i < end; ++i) {
      const Slot s = slot_at(i);
      const Items::Record& r = items.records[std::uint32_t(known[i])];
      Placement& p = placement(s);
      // Items that move together stay in a common chunk: a new chunk lies where the old one would have moved with them.
      const dvec3 offset(p.origin);
      const std::uint32_t own = p.chunk;
      const std::uint32_t chunk = chunks_.find(r.origin, own, moved_to[own],
                                               glm::length(offset) <= chunks_.size() ? r.origin - offset : r.origin);
      moved_to[own] = chunk;
      p = place(r.linear, r.origin, chunk);
      materials_[s] = r.material;
      Aabb grown = taken;
      grown.grow(r.box);
      const bool other_mesh = !all_stay && !has_mesh(s, r);
      const bool stays = !other_mesh && (all_stay || r.layers == 0 || r.box.empty() || taken.empty() ||
                                         allowance == 0 || size_of(grown) <= kBlockSlack * block_sizes_[block]);
      if (stays) {
        if (r.layers != 0) taken = grown;
        show(s, r.box, r.layers);
      } else {
        give_up(s);
        appended.push_back({std::uint32_t(known[i]), chunk});
        if (!other_mesh) --allowance;
      }
    }
  }
}

void Snapshot::append_sorted(const Items& items, std::span<const Newcomer> newcomers) {
  if (newcomers.empty()) return;
  std::vector<Aabb> boxes(newcomers.size());
  for (std::size_t i = 0; i < newcomers.size(); ++i) boxes[i] = items.records[newcomers[i].record].box;
  std::vector<std::uint32_t> order = block_order(boxes);
  // Blocks of the order must become blocks of slots. So items from the end of the order complete the last block.
  const std::size_t first = size(), missing = std::min((kBlockSlots - first % kBlockSlots) % kBlockSlots, order.size());
  std::rotate(order.begin(), order.end() - std::ptrdiff_t(missing), order.end());

  bounds_.resize(first + order.size());
  block_sizes_.resize((size() + kBlockSlots - 1) / kBlockSlots, 0.0f);
  Aabb block = union_of(bounds_, first / kBlockSlots * kBlockSlots, first);
  std::uint32_t chunk = kNone;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const Newcomer& newcomer = newcomers[order[i]];
    const Items::Record& r = items.records[newcomer.record];
    const Slot s = Slot(first + i);
    chunk = newcomer.chunk != kNone ? newcomer.chunk : chunks_.find(r.origin, chunk, chunk, r.origin);
    append(items, newcomer.record, chunk);
    block.grow(r.box);
    if ((s + 1) % kBlockSlots != 0 && i + 1 != order.size()) continue;
    block_sizes_[s / kBlockSlots] = std::max(block_sizes_[s / kBlockSlots], size_of(block));
    block = {};
  }
}

void Snapshot::give_up(Slot s) {
  show(s, {}, 0);
  items_[s] = kNoItem;
  ++given_up_;
}

}  // namespace sightline::core
