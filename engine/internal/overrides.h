// What an engine shows otherwise than the scene says: styles of items, and hidden items. Internal to engine.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "sightline/core/internal/prefetch.h"
#include "sightline/core/internal/radix_sort.h"
#include "sightline/core/large_array.h"
#include "sightline/core/snapshot.h"
#include "sightline/engine/item_style.h"

namespace sightline::engine {

/// Values of some of the items, each with its item: dense, in no order. Takes 4 bytes for each id below the largest.
template <class Value>
class ItemMap {
 public:
  struct Entry {
    core::ItemId item;
    Value value;
  };
  std::span<Entry> entries() { return entries_; }
  std::span<const Entry> entries() const { return entries_; }
  bool empty() const { return entries_.empty(); }
  /// In rising order.
  std::vector<core::ItemId> items() const {
    std::vector<core::ItemId> items;
    items.reserve(entries_.size());
    for (const Entry& entry : entries_) items.push_back(entry.item);
    core::radix_sort(items);
    return items;
  }

  void prefetch(core::ItemId item) const {
    if (to_index(item) < places_.size()) core::prefetch(places_[to_index(item)]);
  }
  /// Null where the item has none. Valid until the next insertion or removal.
  const Value* find(core::ItemId item) const {
    const std::uint32_t place = to_index(item) < places_.size() ? places_[to_index(item)] : core::kNone;
    return place == core::kNone ? nullptr : &entries_[place].value;
  }
  Value* find(core::ItemId item) { return const_cast<Value*>(std::as_const(*this).find(item)); }
  /// The item must have none.
  Value& insert(core::ItemId item, Value value) {
    if (to_index(item) >= places_.size()) places_.resize(std::size_t(item) + 1 + to_index(item) / 8, core::kNone);
    places_[to_index(item)] = std::uint32_t(entries_.size());
    return entries_.emplace_back(Entry{item, std::move(value)}).value;
  }
  /// The item must have one.
  void erase(core::ItemId item) {
    const std::uint32_t place = places_[to_index(item)];
    if (place + 1 != entries_.size()) {
      entries_[place] = std::move(entries_.back());
      places_[to_index(entries_[place].item)] = place;
    }
    entries_.pop_back();
    places_[to_index(item)] = core::kNone;
  }
  void clear() { *this = {}; }
  std::size_t memory_bytes() const { return 4 * places_.capacity() + sizeof(Entry) * entries_.capacity(); }

 private:
  core::LargeArray<std::uint32_t> places_;  // by item: in entries_
  core::LargeArray<Entry> entries_;
};

/// A bit per slot, and how many are set.
class SlotFlags {
 public:
  /// False when it was so before.
  bool set(core::Slot slot, bool value);
  /// None where no bit is set.
  std::span<const std::uint64_t> words() const {
    return count_ == 0 ? std::span<const std::uint64_t>() : std::span(words_);
  }
  std::size_t memory_bytes() const { return 8 * words_.capacity(); }

 private:
  std::vector<std::uint64_t> words_;
  std::size_t count_ = 0;
};

/// Material overrides of items, which are rows of the snapshot's table after the scene's materials
/// (Snapshot::set_override_row), hidden items, which are vacant in the snapshot, and a bit for each slot with a ghost
/// or an outline. So cullers, joints, records and the tracer need not know of overrides, and nothing costs anything
/// while there are none.
class Overrides {
 public:
  /// What a change asks of those that follow the snapshot.
  struct Change {
    std::vector<core::Slot> touched;       ///< each once
    std::vector<core::ItemId> uncovered;   ///< items that no longer cover the ends of others
    std::vector<std::uint32_t> materials;  ///< indices of the overrides that were set, in rising order
    bool boxes = false;                    ///< touched slots became vacant, or no longer are
  };

  bool empty() const { return styled_.empty() && hidden_.empty(); }
  /// None where the item has none.
  std::optional<ItemStyle> style(core::ItemId item) const {
    const Styled* styled = styled_.find(item);
    return styled ? std::optional(material_overrides_[styled->material_override].style) : std::nullopt;
  }
  bool is_hidden(core::ItemId item) const { return hidden_.find(item) != nullptr; }
  std::vector<core::ItemId> styled_items() const { return styled_.items(); }
  std::vector<core::ItemId> hidden_items() const { return hidden_.items(); }

  // Items must be known to the snapshot.
  Change set(core::Snapshot& snapshot, std::span<const core::ItemId> items, const ItemStyle& style);
  Change clear(core::Snapshot& snapshot, std::span<const core::ItemId> items);
  Change clear_all(core::Snapshot& snapshot);
  Change hide(core::Snapshot& snapshot, std::span<const core::ItemId> items);
  Change show(core::Snapshot& snapshot, std::span<const core::ItemId> items);
  Change show_all(core::Snapshot& snapshot);

  /// Follows Snapshot::apply(), which has touched these slots: overrides again the items that it made what the scene
  /// says, and forgets those that are gone. Where the overrides have moved in the table, further slots are touched.
  Change follow(core::Snapshot& snapshot, const core::SceneDelta& delta, std::span<const core::Slot> touched);
  /// Overrides the items of another snapshot, which is as the scene says, and forgets those that it has not.
  void restore(core::Snapshot& snapshot);
  /// Follows an exchange of the snapshot for a copy in another order.
  void reorder(const core::Snapshot& snapshot);

  /// A bit per slot; no words where there is no such slot.
  std::span<const std::uint64_t> ghosts() const { return ghosts_.words(); }
  std::span<const std::uint64_t> outlined() const { return outlined_.words(); }

  std::size_t memory_bytes() const;

 private:
  struct Styled {
    std::uint32_t material_override;  // number of a row after the scene's materials
    std::uint32_t material;           // what the scene says
  };
  struct MaterialOverride {
    ItemStyle style;
    std::uint32_t material = core::kNone;
    std::size_t items = 0;
    friend bool operator==(const MaterialOverride& a, const MaterialOverride& b) {
      return a.material == b.material && a.style == b.style;
    }
  };
  struct MaterialOverrideHash {
    std::size_t operator()(const MaterialOverride& material_override) const;
  };
  std::uint32_t take_override(core::Snapshot& snapshot, const ItemStyle& style, std::uint32_t material, Change& change);
  void change_override(core::Snapshot& snapshot, Styled& styled, const ItemStyle& style, Change& change);
  void release_override(std::uint32_t number);
  void set_row(core::Snapshot& snapshot, std::uint32_t number, Change& change);
  void follow_table(core::Snapshot& snapshot, std::span<const std::uint32_t> materials, bool moved, Change& change);
  void mark(core::Slot slot, const ItemStyle& style);
  void forget(core::ItemId item);

  ItemMap<Styled> styled_;
  ItemMap<core::Snapshot::Shown> hidden_;
  std::vector<MaterialOverride> material_overrides_;  // those without items are free
  std::vector<std::uint32_t> free_overrides_;
  std::unordered_map<MaterialOverride, std::uint32_t, MaterialOverrideHash> number_of_;
  std::uint32_t first_override_row_ = 0;  // as last seen
  SlotFlags ghosts_, outlined_;
};

}  // namespace sightline::engine
