// culling: what a view can see. Box tests (frustum_test.h), a culler for small scenes (linear_culler.h), the tree it
// takes for large ones (hierarchy.h), and the production culler below. Beside them, questions of applications to the
// same tree (spatial_queries.h). Uses core alone.
//
// Every culler states a promise. Those here are conservative: an item whose box meets the view volume is in the set.
#pragma once

#include <cstddef>
#include <span>

#include "sightline/core/item_bounds.h"
#include "sightline/core/view.h"
#include "sightline/core/visible_set.h"
#include "sightline/culling/cull_threads.h"
#include "sightline/culling/frame_sample.h"
#include "sightline/culling/hierarchy.h"

namespace sightline::culling {

/// Frustum culling through the hierarchy, on the calling thread. Planes that a subtree lies wholly inside of are not
/// tested below it, and a subtree inside all of them is one range. The slots are exactly those of LinearCuller, and
/// vacant ones within ranges: so what is hidden or removed neither cuts a range in two nor costs a test.
class CpuCuller {
 public:
  /// Any order of slots is right; the one that core::build_bvh gives is fast. Borrows the bounds, which must outlive
  /// the culler.
  explicit CpuCuller(const core::ItemBounds& bounds);

  /// Replaces the contents of `set`; adjacent ranges are merged. Does not allocate once `set` and the
  /// thread's scratch memory have grown to their sizes.
  /// May run on several threads at once, each with a set of its own.
  void cull(const core::View& view, core::VisibleSet& set) const;

  /// Several views in one query: the eyes of a headset, shadow cascades, section views. sets[i] becomes what
  /// cull(views[i]) would make of it. With threads, views are shared out among them where that is quicker.
  void cull(std::span<const core::View> views, std::span<core::VisibleSet> sets, CullThreads* threads = nullptr) const;

  /// Fills in what a controller may want to know of a cull() that left these counters: tested, nodes, intersections and
  /// height. A level of the hierarchy counts as the four of a binary one, a leaf that was looked into as five.
  void describe(const core::CullCounters& counters, FrameSample& sample) const;

  /// To be called, before the next cull, after boxes or layers of `changed` slots have changed or others were appended:
  /// see Hierarchy::update.
  void update(std::span<const core::Slot> changed) { hierarchy_.update(*bounds_, changed); }
  /// The same after any change. Linear in the number of slots.
  void refit() { hierarchy_.refit(*bounds_); }

  const Hierarchy& hierarchy() const { return hierarchy_; }
  std::size_t memory_bytes() const { return hierarchy_.memory_bytes(); }  ///< without the bounds

 private:
  const core::ItemBounds* bounds_;
  Hierarchy hierarchy_;
};

}  // namespace sightline::culling
