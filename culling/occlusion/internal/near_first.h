// Internal: the slots of a set from near to far, in parts. What lies in a part may hide what the next ones hold, so its
// occluder polygons are rasterised before these are tested: most of a plant is then hidden by whole nodes of the
// hierarchy.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/api.h"
#include "sightline/core/visible_set.h"
#include "sightline/culling/frustum/hierarchy.h"
#include "sightline/culling/occlusion/occlusion_test.h"

namespace sightline::culling {

/// Keeps its memory from set to set.
class SIGHTLINE_API NearFirst {
 public:
  /// Cuts a set at the nodes above the leaves of the hierarchy, which must be that of the set. No node of a part begins
  /// nearer than one of an earlier part. Parts grow: near slots are few, and hide most.
  void split(const core::VisibleSet& set, const Hierarchy& hierarchy, const OcclusionTest& test);
  std::span<const core::VisibleSet> parts() const { return std::span(parts_).first(count_); }

 private:
  struct Node {
    float distance;
    std::uint32_t index, slots;
  };
  void find_nodes(const core::VisibleSet& set, const Hierarchy& hierarchy, const OcclusionTest& test);
  void choose_parts();

  std::vector<Node> nodes_;  // of the set
  std::vector<std::uint32_t> slots_of_;
  std::vector<std::uint8_t> part_of_;    // by node
  std::vector<core::VisibleSet> parts_;  // the first count_ of them; the others keep memory
  std::size_t count_ = 0;
};

}  // namespace sightline::culling
