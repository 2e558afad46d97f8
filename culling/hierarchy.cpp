#include "sightline/culling/hierarchy.h"

#include <algorithm>
#include <bit>
#include <cassert>

#include "sightline/culling/internal/kernels.h"

namespace sightline::culling {
namespace {

using core::Aabb;
using core::ItemBounds;

constexpr std::uint32_t blocks(std::uint32_t count, std::uint32_t size) {
  return count / size + (count % size != 0 ? 1 : 0);
}

/// Minimum and maximum that keep a NaN, so that a node above one is neither rejected nor wholly inside.
void lower(float& least, float value) {
  if (value < least || value != value) least = value;
}
void raise(float& most, float value) {
  if (value > most || value != value) most = value;
}

/// Slot by slot, for leaves that are not full or hold NaN.
Aabb union_of_slots(const ItemBounds& bounds, std::uint32_t first, std::uint32_t end) {
  Aabb box;
  for (std::uint32_t slot = first; slot < end; ++slot) {
    for (int axis = 0; axis < 3; ++axis) {
      lower(box.min[axis], bounds.coordinate(axis)[slot]);
      raise(box.max[axis], bounds.coordinate(axis + 3)[slot]);
    }
  }
  return box;
}

Aabb union_of_leaf(const ItemBounds& bounds, std::uint32_t leaf) {
  const std::uint32_t first = leaf * kLeafSize, count = std::uint32_t(bounds.size());
  if (count - first < kLeafSize) return union_of_slots(bounds, first, count);
  const float* const coordinates[6] = {bounds.coordinate(0), bounds.coordinate(1), bounds.coordinate(2),
                                       bounds.coordinate(3), bounds.coordinate(4), bounds.coordinate(5)};
  float box[6];
  if (kernels().leaf_box(coordinates, first, box)) return {{box[0], box[1], box[2]}, {box[3], box[4], box[5]}};
  return union_of_slots(bounds, first, first + kLeafSize);
}

Aabb union_of_lanes(const HierarchyNode& node) {
  Aabb box;
  for (int axis = 0; axis < 3; ++axis) {
    for (int i = 0; i < kLanes; ++i) {
      lower(box.min[axis], node.bounds[axis][i]);
      raise(box.max[axis], node.bounds[axis + 3][i]);
    }
  }
  return box;
}

struct LayerUnion {
  std::uint32_t any = 0, all = ~0u;
};

LayerUnion layers_of_leaf(const ItemBounds& bounds, std::uint32_t leaf) {
  LayerUnion u;
  const std::uint32_t first = leaf * kLeafSize, count = std::uint32_t(bounds.size());
  for (std::uint32_t slot = first; slot < first + std::min(count - first, kLeafSize); ++slot) {
    if (bounds.vacant(slot)) continue;
    u.any |= bounds.layers(slot);
    u.all &= bounds.layers(slot);
  }
  return u;
}

LayerUnion layers_of_lanes(const LayerNode& node) {
  LayerUnion u;
  for (int i = 0; i < kLanes; ++i) {
    u.any |= node.any[i];
    u.all &= node.all[i];
  }
  return u;
}

/// A node of empty lanes.
HierarchyNode empty_node() {
  HierarchyNode node;
  for (int axis = 0; axis < 3; ++axis) {
    std::fill_n(node.bounds[axis], kLanes, Aabb::kFar);
    std::fill_n(node.bounds[axis + 3], kLanes, -Aabb::kFar);
  }
  return node;
}
LayerNode empty_layers() {
  LayerNode node{};
  std::fill_n(node.all, kLanes, ~0u);
  return node;
}

}  // namespace

std::uint32_t Hierarchy::lane_count(int level) const {
  return level == 0 ? blocks(slot_count_, kLeafSize) : std::uint32_t(nodes_[std::size_t(level) - 1].size());
}

/// Gives every level as many nodes as the slots need. Existing nodes stay as they are.
void Hierarchy::resize(const ItemBounds& bounds) {
  assert(bounds.size() < core::kNone);
  slot_count_ = std::uint32_t(bounds.size());
  std::size_t level = 0;
  for (std::uint32_t lanes = blocks(slot_count_, kLeafSize); lanes > 0; lanes = lanes > 1 ? lanes : 0, ++level) {
    lanes = blocks(lanes, kLanes);
    if (level == nodes_.size()) nodes_.emplace_back();
    nodes_[level].resize(lanes, empty_node());
  }
  nodes_.resize(level);
  layers_.resize(bounds.uses_layers() ? level : 0);
  for (std::size_t i = 0; i < layers_.size(); ++i) layers_[i].resize(nodes_[i].size(), empty_layers());
}

void Hierarchy::refit_lane(const ItemBounds& bounds, int level, std::uint32_t lane) {
  const std::size_t l = std::size_t(level);
  const Aabb box = level == 0 ? union_of_leaf(bounds, lane) : union_of_lanes(nodes_[l - 1][lane]);
  HierarchyNode& node = nodes_[l][lane / kLanes];
  for (int axis = 0; axis < 3; ++axis) {
    node.bounds[axis][lane % kLanes] = box.min[axis];
    node.bounds[axis + 3][lane % kLanes] = box.max[axis];
  }
  if (layers_.empty()) return;
  const LayerUnion u = level == 0 ? layers_of_leaf(bounds, lane) : layers_of_lanes(layers_[l - 1][lane]);
  layers_[l][lane / kLanes].any[lane % kLanes] = u.any;
  layers_[l][lane / kLanes].all[lane % kLanes] = u.all;
}

void Hierarchy::refit(const ItemBounds& bounds) {
  if (bounds.size() < slot_count_) nodes_.clear(), layers_.clear();
  resize(bounds);
  for (int level = 0; level < level_count(); ++level)
    for (std::uint32_t lane = 0; lane < lane_count(level); ++lane) refit_lane(bounds, level, lane);
}

void Hierarchy::update(const ItemBounds& bounds, std::span<const core::Slot> changed) {
  const std::uint32_t old_slots = slot_count_;
  const int old_levels = level_count();
  const bool layers_are_new = bounds.uses_layers() && layers_.empty();
  if (bounds.size() < old_slots || layers_are_new) return refit(bounds);
  resize(bounds);
  // A word of marks is a node, with sixteen lanes. A refitted node is a marked lane of the level above.
  constexpr std::uint32_t kAll = (1u << kLanes) - 1u;
  if (empty()) return;
  marks_.assign(nodes_[0].size(), 0);
  for (const core::Slot slot : changed)
    if (!bounds.vacant(slot)) marks_[slot / (kLeafSize * kLanes)] |= 1u << slot / kLeafSize % kLanes;
  for (std::uint32_t leaf = old_slots / kLeafSize; leaf < lane_count(0); ++leaf)
    marks_[leaf / kLanes] |= 1u << leaf % kLanes;
  for (int level = 0; level < level_count(); ++level) {
    const std::uint32_t count = std::uint32_t(nodes_[std::size_t(level)].size()), used = lane_count(level);
    for (std::uint32_t node = 0; node < count; ++node) {
      // All lanes of a new level must be refitted.
      std::uint32_t rest = level < old_levels ? marks_[node] : kAll;
      if (used - node * kLanes < std::uint32_t(kLanes)) rest &= (1u << (used - node * kLanes)) - 1u;
      const bool looked_at = rest != 0;
      for (; rest != 0; rest &= rest - 1)
        refit_lane(bounds, level, node * kLanes + std::uint32_t(std::countr_zero(rest)));
      // In place: the word of the level above lies at or before this one, whose marks have been taken.
      marks_[node] = 0;
      if (looked_at) marks_[node / kLanes] |= 1u << node % kLanes;
    }
  }
}

std::size_t Hierarchy::node_count() const {
  std::size_t count = 0;
  for (const auto& level : nodes_) count += level.size();
  return count;
}

std::size_t Hierarchy::memory_bytes() const {
  std::size_t bytes = marks_.capacity() * sizeof(marks_[0]);
  for (const auto& level : nodes_) bytes += level.capacity() * sizeof(HierarchyNode);
  for (const auto& level : layers_) bytes += level.capacity() * sizeof(LayerNode);
  return bytes;
}

}  // namespace sightline::culling
