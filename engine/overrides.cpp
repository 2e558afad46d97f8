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

/// Calls visit(item, slot) for each of the items once, in the order of their slots, so that neighbours meet in caches,
/// and prefetch(item, slot) ahead of it. Items of a delta may have no slot.
template <class Prefetch, class Visit>
void for_each_slot(const Snapshot& snapshot, std::span<const ItemId> items, const Prefetch& prefetch,
                   const Visit& visit) {
  std::vector<std::uint64_t> places;  // slot << 32 | item
  places.reserve(items.size());
  for (const ItemId item : items) places.push_back(std::uint64_t(snapshot.slot(item)) << 32 | to_index(item));
  core::radix_sort<32>(places);
  places.erase(std::unique(places.begin(), places.end()), places.end());
  const auto call = [&](const auto& function, std::size_t i) { function(ItemId(places[i]), Slot(places[i] >> 32)); };
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (i + core::kPrefetchAhead < places.size()) call(prefetch, i + core::kPrefetchAhead);
    call(visit, i);
  }
}

}  // namespace

std::size_t Overrides::LookHash::operator()(const Look& look) const {
  const core::vec3 colour = look.style.colour.value_or(core::vec3(-1.0f));
  std::size_t hash = look.material;
  for (const float value : {colour.r, colour.g, colour.b, look.style.alpha})
    hash = hash * 0x9e3779b97f4a7c15u + std::bit_cast<std::uint32_t>(value + 0.0f);  // -0 equals 0
  return hash * 4 + (look.style.ghost ? 1 : 0) + (look.style.outline ? 2 : 0);
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

// --- looks -----------------------------------------------------------------------------------------------------------

/// The number of a look, which gains one item.
std::uint32_t Overrides::take_look(Snapshot& snapshot, const ItemStyle& style, std::uint32_t material, Change& change) {
  const Look wanted{style, material};
  const auto [at, fresh] = number_of_.try_emplace(wanted, kNone);
  if (fresh && free_looks_.empty()) {
    at->second = std::uint32_t(looks_.size());
    looks_.push_back(wanted);
  } else if (fresh) {
    at->second = free_looks_.back();
    free_looks_.pop_back();
    looks_[at->second] = wanted;
  }
  if (fresh) set_row(snapshot, at->second, change);
  ++looks_[at->second].items;
  return at->second;
}

void Overrides::release_look(std::uint32_t number) {
  Look& look = looks_[number];
  if (--look.items > 0) return;
  number_of_.erase(look);
  free_looks_.push_back(number);
}

void Overrides::set_row(Snapshot& snapshot, std::uint32_t number, Change& change) {
  snapshot.set_look(number, row_of(snapshot, looks_[number].style, looks_[number].material));
  first_look_ = snapshot.first_look();
  change.materials.push_back(first_look_ + number);
}

// --- styles of items -------------------------------------------------------------------------------------------------

Overrides::Change Overrides::set(Snapshot& snapshot, std::span<const ItemId> items, const ItemStyle& style) {
  if (style == ItemStyle()) return clear(snapshot, items);
  Change change;
  change.touched.reserve(items.size());
  const auto prefetch = [&](ItemId item, Slot slot) {
    styled_.prefetch(item);
    core::prefetch_slot(snapshot, slot);
  };
  for_each_slot(snapshot, items, prefetch, [&](ItemId item, Slot slot) {
    Styled* styled = styled_.find(item);
    if (styled && looks_[styled->look].style == style) return;
    const bool was_opaque = snapshot.opaque(slot);
    const std::uint32_t material = styled ? styled->material : snapshot.material(slot);
    const std::uint32_t look = take_look(snapshot, style, material, change);
    if (styled) {
      release_look(styled->look);
      styled->look = look;
    } else {
      styled_.insert(item, {look, material});
    }
    snapshot.set_material(slot, snapshot.first_look() + look);
    mark(slot, style);
    change.touched.push_back(slot);
    if (was_opaque && !snapshot.opaque(slot)) change.uncovered.push_back(item);
  });
  std::sort(change.materials.begin(), change.materials.end());
  return change;
}

Overrides::Change Overrides::clear(Snapshot& snapshot, std::span<const ItemId> items) {
  Change change;
  const auto prefetch = [&](ItemId item, Slot slot) {
    styled_.prefetch(item);
    core::prefetch_slot(snapshot, slot);
  };
  for_each_slot(snapshot, items, prefetch, [&](ItemId item, Slot slot) {
    const Styled* styled = styled_.find(item);
    if (!styled) return;
    const bool was_opaque = snapshot.opaque(slot);
    snapshot.set_material(slot, styled->material);
    mark(slot, {});
    release_look(styled->look);
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
  const auto prefetch = [&](ItemId item, Slot slot) {
    hidden_.prefetch(item);
    core::prefetch_box(snapshot, slot);
  };
  for_each_slot(snapshot, items, prefetch, [&](ItemId item, Slot slot) {
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
  const auto prefetch = [&](ItemId item, Slot slot) {
    hidden_.prefetch(item);
    core::prefetch_box(snapshot, slot);
  };
  for_each_slot(snapshot, items, prefetch, [&](ItemId item, Slot slot) {
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

// --- edits and new orders --------------------------------------------------------------------------------------------

void Overrides::forget(ItemId item) {
  if (const Styled* styled = styled_.find(item)) {
    release_look(styled->look);
    styled_.erase(item);
  }
  if (hidden_.find(item)) hidden_.erase(item);
}

Overrides::Change Overrides::follow(Snapshot& snapshot, const core::SceneDelta& delta, std::span<const Slot> touched) {
  Change change;
  if (empty()) return change;
  for (const Slot slot : touched) mark(slot, {});
  for (const ItemId item : delta.removed) forget(item);
  const bool looks_moved = first_look_ != snapshot.first_look();
  std::vector<Slot> vacated;
  for (const auto* list : {&delta.changed, &delta.inserted})
    for_each_slot(
        snapshot, *list, [](ItemId, Slot) {},
        [&](ItemId item, Slot slot) {
          if (Styled* styled = styled_.find(item)) {
            const ItemStyle style = looks_[styled->look].style;
            styled->material = snapshot.material(slot);
            const std::uint32_t look = take_look(snapshot, style, styled->material, change);
            release_look(styled->look);
            styled->look = look;
            snapshot.set_material(slot, snapshot.first_look() + look);
            mark(slot, style);
          }
          if (Snapshot::Shown* shown = hidden_.find(item)) {
            *shown = snapshot.shown(slot);
            vacated.push_back(slot);
          }
        });
  snapshot.hide(vacated);
  if (looks_moved || !delta.materials.empty()) follow_table(snapshot, delta.materials, looks_moved, change);
  std::sort(change.materials.begin(), change.materials.end());
  return change;
}

/// Follows edits of materials, and the looks when the scene's materials have taken their place in the table.
void Overrides::follow_table(Snapshot& snapshot, std::span<const std::uint32_t> materials, bool moved, Change& change) {
  first_look_ = snapshot.first_look();
  std::vector<bool> turned(looks_.size());  // no longer opaque
  bool any_turned = false;
  for (std::uint32_t number = 0; number < looks_.size(); ++number) {
    const Look& look = looks_[number];
    if (look.items == 0) continue;
    if (std::binary_search(materials.begin(), materials.end(), look.material)) {
      const bool was_opaque = snapshot.materials()[first_look_ + number].a >= 1.0f;
      set_row(snapshot, number, change);
      turned[number] = was_opaque && snapshot.materials()[first_look_ + number].a < 1.0f;
      any_turned |= turned[number];
    } else if (moved) {
      change.materials.push_back(first_look_ + number);
    }
  }
  if (!moved && !any_turned) return;
  for (const auto& [item, styled] : styled_.entries()) {
    const Slot slot = snapshot.slot(item);
    if (moved) {
      snapshot.set_material(slot, first_look_ + styled.look);
      change.touched.push_back(slot);
    }
    if (turned[styled.look]) change.uncovered.push_back(item);
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
    const std::uint32_t look = take_look(snapshot, looks_[styled.look].style, styled.material, change);
    release_look(styled.look);
    styled.look = look;
  }
  for (std::uint32_t number = 0; number < looks_.size(); ++number)
    if (looks_[number].items > 0) set_row(snapshot, number, change);
  for (const auto& [item, styled] : styled_.entries())
    snapshot.set_material(snapshot.slot(item), snapshot.first_look() + styled.look);
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
  for (const auto& [item, styled] : styled_.entries()) mark(snapshot.slot(item), looks_[styled.look].style);
}

std::size_t Overrides::memory_bytes() const {
  return styled_.memory_bytes() + hidden_.memory_bytes() + looks_.capacity() * sizeof(Look) +
         number_of_.size() * (sizeof(Look) + 32) + ghosts_.memory_bytes() + outlined_.memory_bytes();
}

}  // namespace sightline::engine
