// culling/frustum: which boxes meet the view volume. Box tests (frustum_test.h), a culler for small scenes
// (linear_culler.h), the hierarchy for large ones (hierarchy.h), and the production culler below. Uses core alone; the
// other rooms of culling use it.
//
// Every culler states a promise. Those here are conservative: an item whose box meets the view volume is in the set.
#pragma once

#include <cstddef>
#include <span>

#include "sightline/core/api.h"
#include "sightline/core/item_bounds.h"
#include "sightline/core/thread_pool.h"
#include "sightline/core/view.h"
#include "sightline/core/visible_set.h"
#include "sightline/culling/frustum/hierarchy.h"

namespace sightline::culling {

/// Frustum culling through the hierarchy, on the calling thread. A plane is not tested below a subtree that lies wholly
/// inside it. A subtree inside all planes is one range. The slots are exactly those of LinearCuller, plus vacant ones
/// within ranges: hidden and removed items neither cut a range in two nor cost a test.
class SIGHTLINE_API CpuCuller {
 public:
  /// Any order of slots is right; that of core::block_order is fast. Borrows the bounds, which must outlive the culler.
  explicit CpuCuller(const core::ItemBounds& bounds);

  /// Replaces the contents of `set` and merges adjacent ranges. Does not allocate once `set` and the thread's scratch
  /// memory have grown to their sizes. May run on several threads at once, each with a set of its own.
  void cull(const core::View& view, core::VisibleSet& set) const;

  /// Several views in one query: the eyes of a headset, shadow cascades, section views. sets[i] becomes the result of
  /// cull(views[i]). With `threads`, views are distributed among them where that is faster.
  void cull(std::span<const core::View> views, std::span<core::VisibleSet> sets,
            core::ThreadPool* threads = nullptr) const;

  /// Call this before the next cull when boxes or layers of `changed` slots have changed or slots were appended: see
  /// Hierarchy::update.
  void update(std::span<const core::Slot> changed, core::ThreadPool* threads = nullptr) {
    hierarchy_.update(*bounds_, changed, threads);
  }
  /// Follows any change. Linear in the number of slots.
  void refit(core::ThreadPool* threads = nullptr) { hierarchy_.refit(*bounds_, threads); }

  const Hierarchy& hierarchy() const { return hierarchy_; }
  std::size_t memory_bytes() const { return hierarchy_.memory_bytes(); }  ///< without the bounds

 private:
  const core::ItemBounds* bounds_;
  Hierarchy hierarchy_;
};

}  // namespace sightline::culling
