#include "sightline/culling/hierarchy.h"

#include <algorithm>
#include <cassert>

#include "sightline/culling/kernels.h"

namespace sightline::culling {
namespace {

using core::Aabb;
using core::ItemBounds;

constexpr std::uint32_t blocks(std::uint32_t count, std::uint32_t size) {
  return count / size + (count % size != 0 ? 1 : 0);
}

/// Unlike Aabb::empty(), false for a box with NaN: that must be drawn.
bool surely_empty(const ItemBounds& bounds, std::size_t slot) {
  for (int axis = 0; axis < 3; ++axis)
    if (bounds.coordinate(axis)[slot] > bounds.coordinate(axis + 3)[slot]) return true;
  return false;
}

/// Minimum and maximum that a NaN sticks to: a node above one is then neither rejected nor wholly inside.
void lower(float& least, float value) {
  if (value < least || value != value) least = value;
}
void raise(float& most, float value) {
  if (value > most || value != value) most = value;
}

/// Slot by slot, for leaves that are not full or hold empty boxes or NaN.
Aabb union_of_slots(const ItemBounds& bounds, std::uint32_t first, std::uint32_t end, bool& some_empty) {
  Aabb box;
  for (std::uint32_t slot = first; slot < end; ++slot) {
    if (surely_empty(bounds, slot)) {
      some_empty = true;
      continue;
    }
    for (int axis = 0; axis < 3; ++axis) {
      lower(box.min[axis], bounds.coordinate(axis)[slot]);
      raise(box.max[axis], bounds.coordinate(axis + 3)[slot]);
    }
  }
  return box;
}

Aabb union_of_leaf(const ItemBounds& bounds, std::uint32_t leaf, std::uint32_t slot_count, const Kernels& kernel,
                   bool& some_empty) {
  const std::uint32_t first = leaf * kLeafSize;
  if (slot_count - first < kLeafSize) return union_of_slots(bounds, first, slot_count, some_empty);
  const float* const coordinates[6] = {bounds.coordinate(0), bounds.coordinate(1), bounds.coordinate(2),
                                       bounds.coordinate(3), bounds.coordinate(4), bounds.coordinate(5)};
  float box[6];
  if (kernel.leaf_box(coordinates, first, box)) return {{box[0], box[1], box[2]}, {box[3], box[4], box[5]}};
  return union_of_slots(bounds, first, first + kLeafSize, some_empty);
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

void set_lane(HierarchyNode& node, std::uint32_t lane, const Aabb& box) {
  for (int axis = 0; axis < 3; ++axis) {
    node.bounds[axis][lane] = box.min[axis];
    node.bounds[axis + 3][lane] = box.max[axis];
  }
}

struct LayerUnion {
  std::uint32_t any = 0, all = ~0u;
  bool hidden = false;
};

void set_lane(LayerNode& node, std::uint32_t lane, const LayerUnion& layers) {
  node.any[lane] = layers.any;
  node.all[lane] = layers.all;
  if (layers.hidden) node.some_hidden = std::uint16_t(node.some_hidden | 1u << lane);
}

}  // namespace

Hierarchy::Hierarchy(const ItemBounds& bounds, std::size_t slot_count) : slot_count_(std::uint32_t(slot_count)) {
  assert(slot_count <= bounds.size() && slot_count < core::kNone);
  if (slot_count == 0) return;
  std::size_t total = 0;
  std::uint32_t lanes = blocks(slot_count_, kLeafSize);
  do {
    first_node_.push_back(total);
    lanes = blocks(lanes, kLanes);
    total += lanes;
  } while (lanes > 1);
  nodes_.resize(total);
  for (std::uint32_t lane = 0; lane < kLanes; ++lane) set_lane(nodes_[0], lane, {});
  std::fill(nodes_.begin(), nodes_.end(), HierarchyNode(nodes_[0]));
  refit(bounds);
}

std::size_t Hierarchy::level_end(int level) const {
  return level + 1 < level_count() ? first_node_[std::size_t(level) + 1] : nodes_.size();
}

std::span<const HierarchyNode> Hierarchy::level(int level) const {
  const std::size_t first = first_node_[std::size_t(level)];
  return {nodes_.data() + first, level_end(level) - first};
}

std::span<const LayerNode> Hierarchy::layers(int level) const {
  const std::size_t first = first_node_[std::size_t(level)];
  return layers_.empty() ? std::span<const LayerNode>()
                         : std::span<const LayerNode>(layers_.data() + first, level_end(level) - first);
}

std::uint32_t Hierarchy::lane_count(int level) const {
  return level == 0 ? blocks(slot_count_, kLeafSize) : std::uint32_t(this->level(level - 1).size());
}

void Hierarchy::refit(const ItemBounds& bounds) {
  assert(slot_count_ <= bounds.size());
  bool some_empty = false;
  refit_boxes(bounds, some_empty);
  if (bounds.uses_layers() || some_empty)
    refit_layers(bounds);
  else
    layers_ = {};
}

void Hierarchy::refit_boxes(const ItemBounds& bounds, bool& some_empty) {
  const Kernels& kernel = kernels();
  for (int level = 0; level < level_count(); ++level) {
    HierarchyNode* nodes = nodes_.data() + first_node_[std::size_t(level)];
    const HierarchyNode* below = level > 0 ? nodes_.data() + first_node_[std::size_t(level) - 1] : nullptr;
    const std::uint32_t lanes = lane_count(level);
    for (std::uint32_t i = 0; i < lanes; ++i) {
      const Aabb box =
          level == 0 ? union_of_leaf(bounds, i, slot_count_, kernel, some_empty) : union_of_lanes(below[i]);
      set_lane(nodes[i / kLanes], i % kLanes, box);
    }
  }
}

void Hierarchy::refit_layers(const ItemBounds& bounds) {
  layers_.assign(nodes_.size(), LayerNode{});
  for (std::uint32_t leaf = 0; leaf < lane_count(0); ++leaf) {
    LayerUnion u;
    const std::uint32_t first = leaf * kLeafSize, end = std::min(slot_count_ - first, kLeafSize) + first;
    for (std::uint32_t slot = first; slot < end; ++slot) {
      const std::uint32_t own = surely_empty(bounds, slot) ? 0 : bounds.layers(slot);
      u.any |= own;
      u.all &= own;
      u.hidden |= own == 0;
    }
    set_lane(layers_[leaf / kLanes], leaf % kLanes, u);
  }
  for (int level = 1; level < level_count(); ++level) {
    LayerNode* nodes = layers_.data() + first_node_[std::size_t(level)];
    const LayerNode* below = layers_.data() + first_node_[std::size_t(level) - 1];
    const std::uint32_t lanes = lane_count(level), lanes_below = lane_count(level - 1);
    for (std::uint32_t i = 0; i < lanes; ++i) {
      LayerUnion u;
      const std::uint32_t used = std::min(lanes_below - i * kLanes, std::uint32_t(kLanes));
      for (std::uint32_t k = 0; k < used; ++k) {
        u.any |= below[i].any[k];
        u.all &= below[i].all[k];
      }
      u.hidden = below[i].some_hidden != 0;
      set_lane(nodes[i / kLanes], i % kLanes, u);
    }
  }
}

std::size_t Hierarchy::memory_bytes() const {
  return nodes_.capacity() * sizeof(HierarchyNode) + layers_.capacity() * sizeof(LayerNode);
}

}  // namespace sightline::culling
