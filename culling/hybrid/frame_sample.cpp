#include "sightline/culling/hybrid/frame_sample.h"

#include <bit>

#include "sightline/culling/frustum/hierarchy.h"

namespace sightline::culling {

void describe(const Hierarchy& hierarchy, const core::CullCounters& counters, FrameSample& sample) {
  const std::uint64_t nodes = counters.nodes_tested / kLanes, leaves = counters.boxes_tested / kLeafSize;
  sample.tested = double(counters.nodes_tested + counters.boxes_tested);
  sample.nodes = double(hierarchy.node_count() * kLanes + hierarchy.lane_count(0) * kLeafSize);
  sample.intersections = double((nodes > 0 ? nodes - 1 : 0) + leaves);
  sample.height = double(counters.levels_walked * std::countr_zero(unsigned(kLanes)) +
                         (leaves > 0 ? std::countr_zero(kLeafSize) : 0));
}

}  // namespace sightline::culling
