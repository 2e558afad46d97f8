#include "sightline/engine/internal/overrides.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "sightline/core/internal/radix_sort.h"
#include "sightline/core/internal/snapshot_prefetch.h"

namespace sightline::engine {
namespace {

using core::ItemId;
using core::kNone;
using core::Slot;
using core::Snapshot;

constexpr float kGhostAlpha = 0.5f;  // of a ghost where it is seen edge-on: below 1, so that it is not opaque

glm::vec4 row_of(const Snapshot& snapshot, const ItemStyle& style, std::uint32_t material) {
  const core::Material unnamed;
  glm::vec4 row = material == kNone ? glm::vec4(unnamed.colour, unnamed.alpha) : snapshot.materials()[material];
  if (style.colour) row = glm::vec4(*style.colour, row.a);
  row.a *= style.alpha;
  if (style.ghost) row.a *= kGhostAlpha;
  return row;
}

/// Calls visit(item, slot) for each of the items once, in the order of their slots, so that neighbours meet in caches.
/// Ahead of that it prefetches their entries of `known` and what `prefetch` does of their slots. Items of a delta may
/// have no slot.
template <class Known, class Prefetch, class Visit>
void for_each_slot(const Snapshot& snapshot, std::span<const ItemId> items, const Known& known,
                   const Prefetch& prefetch, const Visit& visit) {
  std::vector<std::uint64_t> places;  // slot << 32 | item
  places.reserve(items.size());
  for (const ItemId item : items) places.push_back(std::uint64_t(snapshot.slot(item)) << 32 | to_index(item));
  core::radix_sort<32>(places);
  places.erase(std::unique(places.begin(), places.end()), places.end());
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (const std::size_t ahead = i + core::kPrefetchAhead; ahead < places.size()) {
      known.prefetch(ItemId(places[ahead]));
      prefetch(snapshot, Slot(places[ahead] >> 32));
    }
    visit(ItemId(places[i]), Slot(places[i] >> 32));
  }
}

}  // namespace

std::size_t Overrides::MaterialOverrideHash::operator()(const MaterialOverride& material_override) const {
  const core::vec3 colour = material_override.style.colour.value_or(core::vec3(-1.0f));
  std::size_t hash = material_override.material;
  for (const float value : {colour.r, colour.g, colour.b, material_override.style.alpha})
    hash = hash * 0x9e3779b97f4a7c15u + std::bit_cast<std::uint32_t>(value + 0.0f);  // -0 equals 0
  return hash * 4 + (material_override.style.ghost ? 1 : 0) + (material_override.style.outline ? 2 : 0);
}

bool SlotFlags::set(Slot slot, bool value) {
  const std::size_t word = slot / 64;
  if (word >= words_.size()) {
    if (!value) return false;
    words_.resize(word + 1 + word / 8);
  }
  const std::uint64_t bit = std::uint64_t(1) << slot % 64;
  if (((words_[word] & bit) != 0) == value) return false;
  words_[word] ^= bit;
  count_ += value ? 1 : std::size_t(-1);
  return true;
}

void Overrides::mark(Slot slot, const ItemStyle& style) {
  ghosts_.set(slot, style.ghost);
  outlined_.set(slot, style.outline);
}

// --- material overrides -------------------------------------------------------------------------------------------

/// The number of a material override, which gains one item.
std::uint32_t Overrides::take_override(Snapshot& snapshot, const ItemStyle& style, std::uint32_t material,
                                       Change& change) {
  const MaterialOverride wanted{style, material};
  const auto [at, fresh] = number_of_.try_emplace(wanted, kNone);
  if (fresh && free_overrides_.empty()) {
    at->second = std::uint32_t(material_overrides_.size());
    material_overrides_.push_back(wanted);
  } else if (fresh) {
    at->second = free_overrides_.back();
    free_overrides_.pop_back();
    material_overrides_[at->second] = wanted;
  }
  if (fresh) set_row(snapshot, at->second, change);
  ++material_overrides_[at->second].items;
  return at->second;
}

/// Gives an item the override of a style. The one that it had is released last, since it may be the same.
void Overrides::change_override(Snapshot& snapshot, Styled& styled, const ItemStyle& style, Change& change) {
  const std::uint32_t before = styled.material_override;
  styled.material_override = take_override(snapshot, style, styled.material, change);
  if (before != kNone) release_override(before);
}

void Overrides::release_override(std::uint32_t number) {
  MaterialOverride& material_override = material_overrides_[number];
  if (--material_override.items > 0) return;
  number_of_.erase(material_override);
  free_overrides_.push_back(number);
}

void Overrides::set_row(Snapshot& snapshot, std::uint32_t number, Change& change) {
  snapshot.set_override_row(number,
                            row_of(snapshot, material_overrides_[number].style, material_overrides_[number].material));
  first_override_row_ = snapshot.first_override_row();
  change.materials.push_back(first_override_row_ + number);
}

// --- styles of items -------------------------------------------------------------------------------------------------

Overrides::Change Overrides::set(Snapshot& snapshot, std::span<const ItemId> items, const ItemStyle& style) {
  if (style == ItemStyle()) return clear(snapshot, items);
  Change change;
  change.touched.reserve(items.size());
  for_each_slot(snapshot, items, styled_, core::prefetch_slot, [&](ItemId item, Slot slot) {
    Styled* styled = styled_.find(item);
    if (styled && material_overrides_[styled->material_override].style == style) return;
    const bool was_opaque = snapshot.opaque(slot);
    Styled now = styled ? *styled : Styled{kNone, snapshot.material(slot)};
    change_override(snapshot, now, style, change);
    if (styled)
      *styled = now;
    else
      styled_.insert(item, now);
    snapshot.set_material(slot, snapshot.first_override_row() + now.material_override);
    mark(slot, style);
    change.touched.push_back(slot);
    if (was_opaque && !snapshot.opaque(slot)) change.uncovered.push_back(item);
  });
  std::sort(change.materials.begin(), change.materials.end());
  return change;
}

Overrides::Change Overrides::clear(Snapshot& snapshot, std::span<const ItemId> items) {
  Change change;
  for_each_slot(snapshot, items, styled_, core::prefetch_slot, [&](ItemId item, Slot slot) {
    const Styled* styled = styled_.find(item);
    if (!styled) return;
    const bool was_opaque = snapshot.opaque(slot);
    snapshot.set_material(slot, styled->material);
    mark(slot, {});
    release_override(styled->material_override);
    styled_.erase(item);
    change.touched.push_back(slot);
    if (was_opaque && !snapshot.opaque(slot)) change.uncovered.push_back(item);
  });
  if (styled_.empty()) styled_.clear();  // frees memory
  return change;
}

Overrides::Change Overrides::clear_all(Snapshot& snapshot) {
  std::vector<ItemId> items;
  for (const auto& entry : styled_.entries()) items.push_back(entry.item);
  return clear(snapshot, items);
}

// --- hidden items ----------------------------------------------------------------------------------------------------

Overrides::Change Overrides::hide(Snapshot& snapshot, std::span<const ItemId> items) {
  Change change;
  change.boxes = true;
  for_each_slot(snapshot, items, hidden_, core::prefetch_box, [&](ItemId item, Slot slot) {
    if (hidden_.find(item)) return;
    hidden_.insert(item, snapshot.shown(slot));
    change.touched.push_back(slot);
    change.uncovered.push_back(item);
  });
  snapshot.hide(change.touched);
  return change;
}

Overrides::Change Overrides::show(Snapshot& snapshot, std::span<const ItemId> items) {
  Change change;
  change.boxes = true;
  std::vector<Snapshot::Shown> as;
  for_each_slot(snapshot, items, hidden_, core::prefetch_box, [&](ItemId item, Slot slot) {
    const Snapshot::Shown* shown = hidden_.find(item);
    if (!shown) return;
    as.push_back(*shown);
    change.touched.push_back(slot);
    hidden_.erase(item);
  });
  snapshot.show(change.touched, as);
  if (hidden_.empty()) hidden_.clear();  // frees memory
  return change;
}

Overrides::Change Overrides::show_all(Snapshot& snapshot) {
  std::vector<ItemId> items;
  for (const auto& entry : hidden_.entries()) items.push_back(entry.item);
  return show(snapshot, items);
}

// --- edits and new scene versions ------------------------------------------------------------------------------------

void Overrides::forget(ItemId item) {
  if (const Styled* styled = styled_.find(item)) {
    release_override(styled->material_override);
    styled_.erase(item);
  }
  if (hidden_.find(item)) hidden_.erase(item);
}

Overrides::Change Overrides::follow(Snapshot& snapshot, const core::SceneDelta& delta, std::span<const Slot> touched) {
  Change change;
  if (empty()) return change;
  for (const Slot slot : touched) mark(slot, {});
  for (const ItemId item : delta.removed) forget(item);
  const bool overrides_moved = first_override_row_ != snapshot.first_override_row();
  std::vector<Slot> vacated;
  for (const auto* list : {&delta.changed, &delta.inserted})
    for_each_slot(
        snapshot, *list, hidden_, [](const Snapshot&, Slot) {},
        [&](ItemId item, Slot slot) {
          if (Styled* styled = styled_.find(item)) {
            const ItemStyle style = material_overrides_[styled->material_override].style;
            styled->material = snapshot.material(slot);
            change_override(snapshot, *styled, style, change);
            snapshot.set_material(slot, snapshot.first_override_row() + styled->material_override);
            mark(slot, style);
          }
          if (Snapshot::Shown* shown = hidden_.find(item)) {
            *shown = snapshot.shown(slot);
            vacated.push_back(slot);
          }
        });
  snapshot.hide(vacated);
  if (overrides_moved || !delta.materials.empty()) follow_table(snapshot, delta.materials, overrides_moved, change);
  std::sort(change.materials.begin(), change.materials.end());
  return change;
}

/// Follows edits of materials, and the overrides when the scene's materials have taken their place in the table.
void Overrides::follow_table(Snapshot& snapshot, std::span<const std::uint32_t> materials, bool moved, Change& change) {
  first_override_row_ = snapshot.first_override_row();
  std::vector<bool> turned(material_overrides_.size());  // no longer opaque
  bool any_turned = false;
  for (std::uint32_t number = 0; number < material_overrides_.size(); ++number) {
    const MaterialOverride& material_override = material_overrides_[number];
    if (material_override.items == 0) continue;
    if (std::binary_search(materials.begin(), materials.end(), material_override.material)) {
      const bool was_opaque = snapshot.materials()[first_override_row_ + number].a >= 1.0f;
      set_row(snapshot, number, change);
      turned[number] = was_opaque && snapshot.materials()[first_override_row_ + number].a < 1.0f;
      any_turned |= turned[number];
    } else if (moved) {
      change.materials.push_back(first_override_row_ + number);
    }
  }
  if (!moved && !any_turned) return;
  for (const auto& [item, styled] : styled_.entries()) {
    const Slot slot = snapshot.slot(item);
    if (moved) {
      snapshot.set_material(slot, first_override_row_ + styled.material_override);
      change.touched.push_back(slot);
    }
    if (turned[styled.material_override]) change.uncovered.push_back(item);
  }
}

void Overrides::restore(Snapshot& snapshot) {
  Change change;
  std::vector<ItemId> gone;
  for (const auto& entry : styled_.entries())
    if (snapshot.slot(entry.item) == kNone) gone.push_back(entry.item);
  for (const auto& entry : hidden_.entries())
    if (snapshot.slot(entry.item) == kNone) gone.push_back(entry.item);
  for (const ItemId item : gone) forget(item);
  for (auto& [item, styled] : styled_.entries()) {
    const Slot slot = snapshot.slot(item);
    styled.material = snapshot.material(slot);
    change_override(snapshot, styled, ItemStyle(material_overrides_[styled.material_override].style), change);
  }
  for (std::uint32_t number = 0; number < material_overrides_.size(); ++number)
    if (material_overrides_[number].items > 0) set_row(snapshot, number, change);
  for (const auto& [item, styled] : styled_.entries())
    snapshot.set_material(snapshot.slot(item), snapshot.first_override_row() + styled.material_override);
  std::vector<Slot> vacated;
  for (auto& [item, shown] : hidden_.entries()) {
    const Slot slot = snapshot.slot(item);
    shown = snapshot.shown(slot);
    vacated.push_back(slot);
  }
  snapshot.hide(vacated);
  reorder(snapshot);
}

void Overrides::reorder(const Snapshot& snapshot) {
  ghosts_ = outlined_ = {};
  for (const auto& [item, styled] : styled_.entries())
    mark(snapshot.slot(item), material_overrides_[styled.material_override].style);
}

std::size_t Overrides::memory_bytes() const {
  return styled_.memory_bytes() + hidden_.memory_bytes() + material_overrides_.capacity() * sizeof(MaterialOverride) +
         number_of_.size() * (sizeof(MaterialOverride) + 32) + ghosts_.memory_bytes() + outlined_.memory_bytes();
}

}  // namespace sightline::engine
