#include "sightline/culling/frustum/hierarchy.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <utility>

#include "sightline/core/internal/prefetch.h"
#include "sightline/culling/frustum/internal/kernels.h"

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
  if (frustum_kernels().leaf_box(coordinates, first, box)) return {{box[0], box[1], box[2]}, {box[3], box[4], box[5]}};
  return union_of_slots(bounds, first, first + kLeafSize);
}

/// Minimum and maximum of the lanes, without branches. Returns false, with anything in `box`, when a lane is NaN.
bool union_of_numbers(const HierarchyNode& node, Aabb& box) {
  bool numbers = true;
  for (int axis = 0; axis < 3; ++axis) {
    const float *low = node.bounds[axis], *high = node.bounds[axis + 3];
    float least[kLanes / 2], most[kLanes / 2];
    int ordered = 0;
    for (int i = 0; i < kLanes; ++i) ordered += low[i] == low[i] && high[i] == high[i];
    for (int i = 0; i < kLanes / 2; ++i) {
      least[i] = std::min(low[i], low[i + kLanes / 2]);
      most[i] = std::max(high[i], high[i + kLanes / 2]);
    }
    for (int i = 1; i < kLanes / 2; ++i) {
      least[0] = std::min(least[0], least[i]);
      most[0] = std::max(most[0], most[i]);
    }
    box.min[axis] = least[0], box.max[axis] = most[0];
    numbers = numbers && ordered == kLanes;
  }
  return numbers;
}

Aabb union_of_lanes(const HierarchyNode& node) {
  Aabb box;
  if (union_of_numbers(node, box)) return box;
  box = {};
  for (int axis = 0; axis < 3; ++axis) {
    for (int i = 0; i < kLanes; ++i) {
      lower(box.min[axis], node.bounds[axis][i]);
      raise(box.max[axis], node.bounds[axis + 3][i]);
    }
  }
  return box;
}

/// Fetches the boxes of marked leaves at once: one after the other, each would wait for memory.
void prefetch_leaves(const ItemBounds& bounds, std::uint32_t node, std::uint32_t marked) {
  for (; marked != 0; marked &= marked - 1) {
    const std::uint32_t leaf = node * kLanes + std::uint32_t(std::countr_zero(marked));
    for (int axis = 0; axis < 6; ++axis)
      core::prefetch(bounds.coordinate(axis) + leaf * kLeafSize, kLeafSize * sizeof(float));
  }
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
  marks_.resize(level);
  for (std::size_t i = 0; i < level; ++i) marks_[i].resize(nodes_[i].size(), 0);
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

/// Marks a leaf and the nodes above it. Where a lane is marked, so are those above it.
void Hierarchy::mark(std::uint32_t leaf) {
  std::uint32_t lane = leaf;
  for (std::vector<std::uint16_t>& marks : marks_) {
    std::uint16_t& node = marks[lane / kLanes];
    const auto bit = std::uint16_t(1u << lane % kLanes);
    if ((node & bit) != 0) return;
    node |= bit;
    lane /= kLanes;
  }
}

void Hierarchy::mark_all(int level) {
  std::vector<std::uint16_t>& marks = marks_[std::size_t(level)];
  std::fill(marks.begin(), marks.end(), std::uint16_t(~0u));
  if (const std::uint32_t last = lane_count(level) % kLanes; last != 0) marks.back() = std::uint16_t((1u << last) - 1u);
}

/// Refits the marked lanes of a node after those below them, and clears the marks.
void Hierarchy::refit_marked(const ItemBounds& bounds, int level, std::uint32_t node) {
  const std::uint32_t marked = std::exchange(marks_[std::size_t(level)][node], std::uint16_t(0));
  if (level == 0) prefetch_leaves(bounds, node, marked);
  for (std::uint32_t rest = marked; rest != 0; rest &= rest - 1) {
    const std::uint32_t lane = node * kLanes + std::uint32_t(std::countr_zero(rest));
    if (level > 0) refit_marked(bounds, level - 1, lane);
    refit_lane(bounds, level, lane);
  }
}

/// Subtrees of a level with some dozens of nodes are jobs for threads; the few nodes above them are refitted at last.
void Hierarchy::refit_marked(const ItemBounds& bounds, core::ThreadPool* threads) {
  constexpr std::size_t kMostJobs = 256;
  if (empty()) return;
  int level = 0;
  while (nodes_[std::size_t(level)].size() > kMostJobs) ++level;
  if (threads)
    threads->run(std::uint32_t(nodes_[std::size_t(level)].size()),
                 [&](std::uint32_t node) { refit_marked(bounds, level, node); });
  refit_marked(bounds, level_count() - 1, 0);
}

void Hierarchy::refit(const ItemBounds& bounds, core::ThreadPool* threads) {
  if (bounds.size() < slot_count_) nodes_.clear(), layers_.clear(), marks_.clear();
  resize(bounds);
  for (int level = 0; level < level_count(); ++level) mark_all(level);
  refit_marked(bounds, threads);
}

void Hierarchy::update(const ItemBounds& bounds, std::span<const core::Slot> changed, core::ThreadPool* threads) {
  const std::uint32_t old_slots = slot_count_;
  const int old_levels = level_count();
  const bool layers_are_new = bounds.uses_layers() && layers_.empty();
  if (bounds.size() < old_slots || layers_are_new) return refit(bounds, threads);
  resize(bounds);
  for (int level = old_levels; level < level_count(); ++level) mark_all(level);
  for (const core::Slot slot : changed)
    if (!bounds.vacant(slot)) mark(slot / kLeafSize);
  if (bounds.size() > old_slots)
    for (std::uint32_t leaf = old_slots / kLeafSize; leaf < lane_count(0); ++leaf) mark(leaf);
  refit_marked(bounds, threads);
}

std::size_t Hierarchy::node_count() const {
  std::size_t count = 0;
  for (const auto& level : nodes_) count += level.size();
  return count;
}

std::size_t Hierarchy::memory_bytes() const {
  std::size_t bytes = 0;
  for (const auto& level : marks_) bytes += level.capacity() * sizeof(level[0]);
  for (const auto& level : nodes_) bytes += level.capacity() * sizeof(HierarchyNode);
  for (const auto& level : layers_) bytes += level.capacity() * sizeof(LayerNode);
  return bytes;
}

}  // namespace sightline::culling
