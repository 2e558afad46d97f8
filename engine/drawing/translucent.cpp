#include "sightline/engine/drawing/internal/translucent.h"

#include <algorithm>
#include <bit>

namespace sightline::engine {
namespace {

/// Adds slots first … end - 1.
void add(core::Slot first, core::Slot end, core::VisibleSet& set) {
  if (end > first) set.ranges.push_back({first, end - first});
}

}  // namespace

void TranslucentSlots::reset(const core::Snapshot& snapshot) {
  blended_slots_ = {};
  size_ = 0;
  if (blended_) (void)update(snapshot, {}, {});
}

std::vector<core::Slot> TranslucentSlots::update(const core::Snapshot& snapshot, std::span<const core::Slot> touched,
                                                 std::span<const std::uint32_t> materials) {
  std::vector<core::Slot> changed;
  if (!blended_) return changed;
  const auto look_at = [&](core::Slot slot) { return blended_slots_.set(slot, !snapshot.opaque(slot)); };
  for (const core::Slot slot : touched) look_at(slot);
  const bool of_scene =
      !materials.empty() && (snapshot.first_override_row() == 0 || materials.front() < snapshot.first_override_row());
  for (core::Slot slot = 0; of_scene && slot < size_; ++slot)
    if (look_at(slot)) changed.push_back(slot);
  for (; size_ < snapshot.size(); ++size_) look_at(size_);
  return changed;
}

void part(const core::VisibleSet& set, culling::SlotBits bits, core::VisibleSet& with, core::VisibleSet& without) {
  with.clear();
  without.clear();
  with.generation = without.generation = set.generation;
  for (const core::SlotRange& range : set.ranges) {
    core::Slot first = range.first;
    const core::Slot end = range.first + range.count;
    while (first < end) {
      const bool has = culling::contains(bits, first);
      core::Slot stop = first;
      for (bool same = true; same && stop < end;) {  // to the end of the run, or of the word
        const std::uint64_t word = stop / 64 < bits.size() ? bits[stop / 64] : 0;
        const std::uint64_t others = (has ? ~word : word) >> stop % 64;
        same = others == 0;
        stop = std::min(end, same ? (stop / 64 + 1) * 64 : stop + core::Slot(std::countr_zero(others)));
      }
      add(first, stop, has ? with : without);
      first = stop;
    }
  }
  for (const core::Slot slot : set.single_slots)
    (culling::contains(bits, slot) ? with : without).single_slots.push_back(slot);
}

}  // namespace sightline::engine
