// The items that are drawn over the finished image, and hide nothing. Internal to engine.
#pragma once

#include <span>
#include <vector>

#include "sightline/core/snapshot.h"
#include "sightline/culling/occlusion/sample_test.h"
#include "sightline/engine/internal/overrides.h"

namespace sightline::engine {

/// Ghosts, and with Transparency::kBlended all items that are not opaque. A bit per slot with kBlended, otherwise
/// nothing.
class TranslucentSlots {
 public:
  TranslucentSlots() = default;
  TranslucentSlots(const Overrides& overrides, bool blended) : overrides_(&overrides), blended_(blended) {}

  /// No words where there are none. Valid until the next change.
  culling::SlotBits bits() const {
    if (!overrides_) return {};
    return blended_ ? blended_slots_.words() : overrides_->ghosts();
  }
  culling::SlotBits ghosts() const { return overrides_ ? overrides_->ghosts() : culling::SlotBits(); }
  culling::SlotBits outlined() const { return overrides_ ? overrides_->outlined() : culling::SlotBits(); }

  /// Follows another order of the items.
  void reset(const core::Snapshot& snapshot);
  /// Follows an edit: Drawing::update(). Returns further slots whose bit has changed, since materials were edited.
  std::vector<core::Slot> update(const core::Snapshot& snapshot, std::span<const core::Slot> touched,
                                 std::span<const std::uint32_t> materials);

 private:
  const Overrides* overrides_ = nullptr;
  bool blended_ = false;
  SlotFlags blended_slots_;
  core::Slot size_ = 0;  // slots that were looked at
};

/// Parts a set by the slots with a bit.
void part(const core::VisibleSet& set, culling::SlotBits bits, core::VisibleSet& with, core::VisibleSet& without);

}  // namespace sightline::engine
