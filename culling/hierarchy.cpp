#include "sightline/culling/hierarchy.h"

#include <algorithm>
#include <cassert>
#include <limits>

namespace sightline::culling {
namespace {

using core::Aabb;
using core::BvhNode;

/// Unlike Aabb::empty(), false for a box with NaN: that must be drawn.
bool surely_empty(const core::ItemBounds& bounds, std::size_t slot) {
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

Aabb union_of_slots(const core::ItemBounds& bounds, std::uint32_t first, std::uint32_t count, bool& some_empty) {
  Aabb box;
  for (std::uint32_t slot = first; slot < first + count; ++slot) {
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

Aabb union_of_lanes(const BoxLanes& lanes) {
  Aabb box;
  for (int axis = 0; axis < 3; ++axis) {
    for (int i = 0; i < kLanes; ++i) {
      lower(box.min[axis], lanes[axis][i]);
      raise(box.max[axis], lanes[axis + 3][i]);
    }
  }
  return box;
}

double half_area(const Aabb& box) {
  if (box.empty()) return 0.0;
  const core::dvec3 d = core::dvec3(box.max) - core::dvec3(box.min);
  return d.x * d.y + d.y * d.z + d.z * d.x;
}

/// Surface of every node of the binary tree, which keeps no boxes itself. Children come after their parents.
std::vector<double> surfaces(const core::ItemBounds& bounds, const core::BvhTree& tree) {
  std::vector<Aabb> boxes(tree.nodes.size());
  std::vector<double> areas(tree.nodes.size());
  for (std::size_t i = tree.nodes.size(); i-- > 0;) {
    const BvhNode& node = tree.nodes[i];
    if (node.leaf()) {
      bool some_empty = false;
      boxes[i] = union_of_slots(bounds, node.first, node.count, some_empty);
    } else {
      assert(node.left > i);
      boxes[i] = boxes[node.left];
      boxes[i].grow(boxes[node.left + 1]);
    }
    areas[i] = half_area(boxes[i]);
  }
  return areas;
}

}  // namespace

/// Turns the binary tree into nodes of up to eight children.
struct Hierarchy::Collapse {
  const core::BvhTree& tree;
  std::vector<double> areas;

  bool stays_leaf(std::uint32_t node) const {
    return tree.nodes[node].leaf() || tree.nodes[node].count <= std::uint32_t(kLanes);
  }

  struct Children {
    std::uint32_t nodes[kLanes];
    int count = 0;
  };

  /// Opens the child of largest surface again and again; the two halves take its place, which keeps the slot order.
  Children children(std::uint32_t parent) const {
    Children c;
    c.nodes[c.count++] = parent;
    while (c.count < kLanes) {
      int widest = -1;
      for (int i = 0; i < c.count; ++i)
        if (!stays_leaf(c.nodes[i]) && (widest < 0 || areas[c.nodes[i]] > areas[c.nodes[widest]])) widest = i;
      if (widest < 0) break;
      std::copy_backward(c.nodes + widest + 1, c.nodes + c.count, c.nodes + c.count + 1);
      const std::uint32_t left = tree.nodes[c.nodes[widest]].left;
      c.nodes[widest] = left;
      c.nodes[widest + 1] = left + 1;
      ++c.count;
    }
    return c;
  }
};

Hierarchy::Hierarchy(const core::ItemBounds& bounds, const core::BvhTree& tree) {
  if (tree.nodes.empty()) return;
  slot_count_ = tree.nodes[0].count;
  assert(tree.nodes[0].first == 0 && slot_count_ <= bounds.size());
  const Collapse collapse{tree, surfaces(bounds, tree)};

  struct Entry {
    std::uint32_t target, depth;
    Collapse::Children children;
  };
  std::vector<Entry> stack{{0, 1, collapse.children(0)}};
  root_ = ChildRef::node(0, stack[0].children.count);
  nodes_.resize(1);
  while (!stack.empty()) {
    const Entry entry = stack.back();
    stack.pop_back();
    depth_ = std::max(depth_, entry.depth);
    HierarchyNode node;
    const BvhNode& last = tree.nodes[entry.children.nodes[entry.children.count - 1]];
    std::fill_n(node.first, kLanes, last.first + last.count);
    std::size_t inner = 0;
    for (int i = 0; i < entry.children.count; ++i) {
      const std::uint32_t child = entry.children.nodes[i];
      node.first[i] = tree.nodes[child].first;
      if (collapse.stays_leaf(child)) {
        node.child[i] = ChildRef::leaf(tree.nodes[child].count);
        continue;
      }
      stack.push_back({std::uint32_t(nodes_.size()), entry.depth + 1, collapse.children(child)});
      node.child[i] = ChildRef::node(std::uint32_t(nodes_.size()), stack.back().children.count);
      nodes_.emplace_back();
      ++inner;
    }
    // Pushed in slot order, taken from the back: turned round, subtrees lie in memory as they are walked.
    std::reverse(stack.end() - std::ptrdiff_t(inner), stack.end());
    nodes_[entry.target] = node;
  }
  nodes_.shrink_to_fit();
  refit(bounds);
}

void Hierarchy::refit(const core::ItemBounds& bounds) {
  assert(slot_count_ <= bounds.size());
  bool some_empty = false;
  refit_boxes(bounds, some_empty);
  if (bounds.uses_layers() || some_empty)
    refit_layers(bounds);
  else
    layers_ = {};
}

void Hierarchy::refit_boxes(const core::ItemBounds& bounds, bool& some_empty) {
  for (std::size_t n = nodes_.size(); n-- > 0;) {
    HierarchyNode& node = nodes_[n];
    for (int i = 0; i < kLanes; ++i) {
      const ChildRef child = node.child[i];
      const Aabb box = child.is_leaf() ? union_of_slots(bounds, node.first[i], child.leaf_count(), some_empty)
                                       : union_of_lanes(nodes_[child.index()].bounds);
      for (int axis = 0; axis < 3; ++axis) {
        node.bounds[axis][i] = box.min[axis];
        node.bounds[axis + 3][i] = box.max[axis];
      }
    }
  }
}

void Hierarchy::refit_layers(const core::ItemBounds& bounds) {
  layers_.resize(nodes_.size());
  for (std::size_t n = nodes_.size(); n-- > 0;) {
    const HierarchyNode& node = nodes_[n];
    LayerNode& layers = layers_[n];
    layers.some_hidden = 0;
    for (int i = 0; i < kLanes; ++i) {
      std::uint32_t any = 0, all = ~0u;
      bool hidden = false;
      if (node.child[i].is_leaf()) {
        for (std::uint32_t k = 0; k < node.child[i].leaf_count(); ++k) {
          const std::size_t slot = node.first[i] + k;
          const std::uint32_t own = surely_empty(bounds, slot) ? 0 : bounds.layers(slot);
          any |= own;
          all &= own;
          hidden |= own == 0;
        }
      } else {
        const LayerNode& below = layers_[node.child[i].index()];
        for (int k = 0; k < node.child[i].lanes(); ++k) {
          any |= below.any[k];
          all &= below.all[k];
        }
        hidden = below.some_hidden != 0;
      }
      layers.any[i] = any;
      layers.all[i] = all;
      if (hidden) layers.some_hidden = std::uint8_t(layers.some_hidden | 1u << i);
    }
  }
}

std::size_t Hierarchy::memory_bytes() const {
  return nodes_.capacity() * sizeof(HierarchyNode) + layers_.capacity() * sizeof(LayerNode);
}

}  // namespace sightline::culling
