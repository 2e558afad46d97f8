// Result of culling, as drawing takes it, and what drawing tells of it. Internal to engine.
#pragma once

#include <cstdint>
#include <vector>

#include "sightline/core/snapshot.h"
#include "sightline/core/view.h"
#include "sightline/core/visible_set.h"
#include "sightline/culling/frustum/hierarchy.h"
#include "sightline/culling/occlusion/sample_test.h"

namespace sightline::engine {

/// The visible items of a view. Borrows everything.
struct Culled {
  const core::View& view;
  const core::Snapshot& snapshot;
  const core::VisibleSet& visible;
  culling::SlotBits lines = {};  ///< slots that the contribution and occlusion tests keep always
  /// Hierarchy of the snapshot's bounds, or null. It makes tests of large sets fast.
  const culling::Hierarchy* hierarchy = nullptr;

  Culled with(const core::VisibleSet& set) const { return {view, snapshot, set, lines, hierarchy}; }
  Culled seen_in(const core::View& other) const { return {other, snapshot, visible, lines, hierarchy}; }
};

/// Visible items that an image leaves out: a bit per slot, or no words where nothing is left out.
struct LeftOut {
  std::vector<std::uint64_t> small, occluded;
};

/// Number of items by what a frame did with them.
struct DrawCounts {
  std::int64_t sampled = 0, items_drawn = 0;  // items that may cover a sample, -1 with the occlusion test; items drawn
  std::int64_t below_min_area = 0;            // items below the minimum projected area that is asked for
  std::int64_t pending = 0;                   // items for which the budget did not suffice
  std::int64_t splats = 0;                    // of these and pending ones, items drawn as one splat each
  std::int64_t triangles = 0;                 // of meshes
};

}  // namespace sightline::engine
