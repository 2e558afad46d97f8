#include "sightline/engine/drawing/internal/translucent.h"

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
      core::Slot stop = first + 1;
      while (stop < end && culling::contains(bits, stop) == has) ++stop;
      add(first, stop, has ? with : without);
      first = stop;
    }
  }
  for (const core::Slot slot : set.single_slots)
    (culling::contains(bits, slot) ? with : without).single_slots.push_back(slot);
}

}  // namespace sightline::engine
