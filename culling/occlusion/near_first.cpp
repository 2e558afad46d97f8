#include "sightline/culling/occlusion/internal/near_first.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sightline/culling/frustum/internal/append_range.h"

namespace sightline::culling {
namespace {

constexpr std::uint32_t kNodeSlots = kLeafSize * kLanes;
constexpr double kFirstShare = 0.01;  // of all slots, in the first part
constexpr double kGrowth = 1.3;       // of the parts from one to the next: some fourteen parts

/// Calls visit(node, range) for the pieces of the set's ranges within single nodes.
template <class Visit>
void for_each_piece(const core::VisibleSet& set, const Visit& visit) {
  for (const core::SlotRange& range : set.ranges) {
    const core::Slot end = range.first + range.count;
    for (core::Slot s = range.first; s < end;) {
      const core::Slot next = std::min(end, (s / kNodeSlots + 1) * kNodeSlots);
      visit(s / kNodeSlots, core::SlotRange{s, next - s});
      s = next;
    }
  }
}

/// The distance of a node of level 0, which is a child of level 1. Infinite where there is none: a view that scales may
/// take the sides of a box to both infinities.
float distance_of(const Hierarchy& hierarchy, std::uint32_t node, const OcclusionTest& test) {
  const float distance = test.distance(hierarchy.box(1, node));
  return std::isnan(distance) ? std::numeric_limits<float>::infinity() : distance;
}

}  // namespace

void NearFirst::split(const core::VisibleSet& set, const Hierarchy& hierarchy, const OcclusionTest& test) {
  find_nodes(set, hierarchy, test);
  choose_parts();
  for (core::VisibleSet& part : parts_) {
    part.clear();
    part.generation = set.generation;
  }
  for_each_piece(set, [&](std::uint32_t node, const core::SlotRange& piece) {
    append_range(piece.first, piece.first + piece.count, parts_[part_of_[node]].ranges);
  });
  for (const core::Slot s : set.single_slots) parts_[part_of_[s / kNodeSlots]].single_slots.push_back(s);
}

/// In order of their distances.
void NearFirst::find_nodes(const core::VisibleSet& set, const Hierarchy& hierarchy, const OcclusionTest& test) {
  slots_of_.assign(hierarchy.level(0).size(), 0);
  for_each_piece(set, [&](std::uint32_t node, const core::SlotRange& piece) { slots_of_[node] += piece.count; });
  for (const core::Slot s : set.single_slots) ++slots_of_[s / kNodeSlots];
  nodes_.clear();
  const bool one = hierarchy.level_count() == 1;
  for (std::uint32_t node = 0; node < slots_of_.size(); ++node)
    if (slots_of_[node] > 0) nodes_.push_back({one ? 0.0f : distance_of(hierarchy, node, test), node, slots_of_[node]});
  std::sort(nodes_.begin(), nodes_.end(), [](const Node& a, const Node& b) {
    return a.distance < b.distance || (a.distance == b.distance && a.index < b.index);
  });
}

void NearFirst::choose_parts() {
  double total = 0.0, done = 0.0;
  for (const Node& node : nodes_) total += node.slots;
  double share = kFirstShare * total, end = share;
  std::uint8_t part = 0;
  part_of_.assign(slots_of_.size(), 0);
  for (const Node& node : nodes_) {
    if (done >= end) {
      ++part;
      share *= kGrowth;
      end = done + share;
    }
    part_of_[node.index] = part;
    done += node.slots;
  }
  count_ = nodes_.empty() ? 0 : std::size_t(part) + 1;
  if (parts_.size() < count_) parts_.resize(count_);
}

}  // namespace sightline::culling
