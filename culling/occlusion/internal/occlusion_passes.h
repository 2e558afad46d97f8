// Which items a frame draws first, and which after them. Internal to culling and engine.
#pragma once

#include <cstdint>
#include <vector>

#include "sightline/core/item_bounds.h"
#include "sightline/core/snapshot.h"
#include "sightline/core/visible_set.h"
#include "sightline/culling/occlusion/internal/near_first.h"
#include "sightline/culling/occlusion/occlusion_test.h"

namespace sightline::culling {

/// Several passes a frame, so that nothing pops: first what the frame before has found open, then, of all others, what
/// the depth of the passes before does not hide. When that is much, its nearest part comes next, and the rest is tested
/// once more. So every frame shows everything that its own view sees. What is drawn first converges to what the test
/// leaves open in the whole image.
class OcclusionPasses {
 public:
  /// What follows the first pass: what is in front of all else, where much is open, since drawing is expensive; or the
  /// other candidates from near to far, in a dozen passes, for which there must be a hierarchy.
  enum class Next { kFront, kNearest };

  /// Begins a frame with its candidates. Slots of `lines` are not tested. `hierarchy`: that of the candidates, or null;
  /// it makes large sets fast. `threads` share in the tests of the frame.
  void begin(const core::VisibleSet& candidates, SlotBits lines, const Hierarchy* hierarchy, core::ThreadPool& threads,
             Next next = Next::kFront);
  /// Finds the next pass. `test`: against the depth of all passes so far, at first of none. False when all that may be
  /// seen is drawn; then the frame should be remembered.
  bool next(const OcclusionTest& test, const core::ItemBounds& bounds);
  /// What to draw now; may be empty.
  const core::VisibleSet& pass() const { return passes_[std::size_t(count_ - 1)]; }
  /// Slots that were drawn in this frame.
  std::size_t drawn() const { return drawn_count_; }
  /// These, in rising order.
  void list_drawn(const core::ItemBounds& bounds, core::VisibleSet& drawn);

  /// After next() has returned false: what the next frame draws first. Of what was drawn, what the depth of all passes
  /// does not hide, and lines.
  void remember(const OcclusionTest& test, const core::ItemBounds& bounds);
  /// Overload for callers that already computed the set.
  void remember(const core::VisibleSet& unoccluded, const core::ItemBounds& bounds);

  /// Forgets the frame before.
  void reset() { unoccluded_.clear(); }
  /// Remembers the same items in another order.
  void follow(const core::Snapshot& former, const core::Snapshot& snapshot);

 private:
  void merge_singles(core::VisibleSet& set, std::vector<core::Slot>& more);
  void find_first(const OcclusionTest& test, const core::ItemBounds& bounds);
  void find_nearest(const OcclusionTest& test, const core::ItemBounds& bounds);
  void find_next(const OcclusionTest& test, const core::ItemBounds& bounds);

  std::vector<std::uint64_t> unoccluded_;                           // a bit per slot, of the last frame
  std::vector<std::uint64_t> drawn_bits_;                           // a bit per slot, of list_drawn()
  std::vector<core::Slot> first_singles_, other_singles_, merged_;  // of ranges that begin() divides
  std::vector<core::VisibleSet> passes_;                            // the first count_ of them; the others keep memory
  SlotBits lines_;
  const Hierarchy* hierarchy_ = nullptr;
  core::ThreadPool* threads_ = nullptr;
  core::VisibleSet pass_, pending_, found_, others_;  // pass_: the one to come
  NearFirst near_first_;                              // of pending_
  std::size_t near_parts_ = 0;                        // of these, tested
  Next next_ = Next::kFront;
  int count_ = 0;
  std::size_t drawn_count_ = 0;
};

}  // namespace sightline::culling
