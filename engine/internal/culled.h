// What a culler hands to what draws. Internal to engine.
#pragma once

#include <cstdint>
#include <vector>

#include "sightline/core/snapshot.h"
#include "sightline/core/view.h"
#include "sightline/core/visible_set.h"
#include "sightline/culling/hierarchy.h"
#include "sightline/culling/sample_test.h"

namespace sightline::engine {

/// What is visible in a view. Borrows everything.
struct Culled {
  const core::View& view;
  const core::Snapshot& snapshot;
  const core::VisibleSet& visible;
  culling::SlotBits lines = {};  ///< slots to which the rules for small and hidden items do not apply
  /// That of the snapshot's bounds, or null. It makes large sets fast.
  const culling::Hierarchy* hierarchy = nullptr;

  Culled with(const core::VisibleSet& set) const { return {view, snapshot, set, lines, hierarchy}; }
};

/// Of what is visible, what a picture leaves out: a bit per slot, or no words where nothing is.
struct LeftOut {
  std::vector<std::uint64_t> small, occluded;
};

}  // namespace sightline::engine
