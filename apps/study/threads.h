// Internal: three ways to share one walk among threads of OpenMP.
#pragma once

#include <vector>

#include "sightline/apps/study/walk.h"

namespace sightline::study {

/// Subtrees of the level that has at least `threads` nodes are dealt out in advance (the first scheme of E. T. Carlos,
/// 2009). Levels above are not tested.
void walk_static(const Frame& f, CompactNode* nodes, WalkSubtree walk, int threads,
                 std::vector<core::VisibleSet>& parts);

/// A task for each child of an open node, down to subtrees of kTaskItems items.
void walk_tasks(const Frame& f, CompactNode* nodes, WalkSubtree walk, OpenNode open, int threads,
                std::vector<core::VisibleSet>& parts);

/// A ring buffer between any two threads, one writing and one reading, so that no lock is needed; a thread gives its
/// next right child away when the receiver's ring is empty and the subtree is worth it (U. Assarsson, P. Stenström, "A
/// case study of load distribution in parallel view frustum culling and collision detection", 2001: lock-free scheme).
void walk_ring(const Frame& f, CompactNode* nodes, WalkSubtree walk, OpenNode open, int threads,
               std::vector<core::VisibleSet>& parts);

}  // namespace sightline::study
