// kd-trees by the surface-area heuristic, evaluated at equally spaced planes ("binned"). Three layouts share one
// builder: bare nodes; nodes with parents and boxes (backtrack); leaves with boxes and ropes (sequential, ropes,
// ropes++).
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "sightline/apps/study/rays/grid_lines.h"
#include "sightline/apps/study/rays/triangle_set.h"
#include "sightline/core/aabb.h"

namespace sightline::study::rays {

/// Eight bytes. An inner node's children lie side by side.
class KdNode {
 public:
  static KdNode inner(int axis, float split, std::uint32_t left) {
    return {std::bit_cast<std::uint32_t>(split), left << 2 | std::uint32_t(axis)};
  }
  static KdNode leaf(std::uint32_t first, std::uint32_t count) { return {first, count << 2 | 3u}; }
  KdNode() = default;

  bool is_leaf() const { return (bits_ & 3u) == 3u; }
  int axis() const { return int(bits_ & 3u); }
  float split() const { return std::bit_cast<float>(value_); }
  std::uint32_t left() const { return bits_ >> 2; }
  /// For leaves: its triangles are `count` indices from `first` on.
  std::uint32_t first() const { return value_; }
  std::uint32_t count() const { return bits_ >> 2; }

 private:
  KdNode(std::uint32_t value, std::uint32_t bits) : value_(value), bits_(bits) {}
  std::uint32_t value_ = 0, bits_ = 3u;
};

struct KdConfig {
  float traversal_cost = 1.0f, intersection_cost = 1.5f;  ///< of a node, of a triangle
  float empty_factor = 0.8f;                              ///< on the cost of a split that cuts off empty space
  std::uint32_t bins = 32;                                ///< planes per axis and node, less one; at most 32
  const GridLines* lines = nullptr;                       ///< if not null, splits lie on these alone
};

struct KdTree {
  static constexpr std::uint32_t kMaxDepth = 60;

  std::vector<KdNode> nodes;  ///< nodes[0] is the root; never empty
  std::vector<std::uint32_t> triangles;
  core::Aabb bounds;

  std::span<const std::uint32_t> triangles_of(const KdNode& leaf) const {
    return {triangles.data() + leaf.first(), leaf.count()};
  }
  std::size_t bytes() const { return nodes.size() * sizeof(KdNode) + triangles.size() * sizeof(std::uint32_t); }
};

/// A box is referenced by each leaf that it overlaps.
KdTree build_kd_tree(std::span<const core::Aabb> boxes, const core::Aabb& bounds, const KdConfig& config = {});

/// Box of every node, in the order of the nodes.
std::vector<core::Aabb> node_boxes(const KdTree& tree);

/// Borrows the tree.
struct KdTreeWithParents {
  const KdTree& tree;
  std::vector<std::uint32_t> parents;
  std::vector<core::Aabb> boxes;

  explicit KdTreeWithParents(const KdTree& kd);
  std::size_t bytes() const {
    return tree.bytes() + parents.size() * sizeof(std::uint32_t) + boxes.size() * sizeof(core::Aabb);
  }
};

/// Nodes of its own, whose leaves name their place in `leaves`; borrows the tree for the triangles.
struct KdTreeWithRopes {
  struct Leaf {
    core::Aabb box;
    std::array<std::uint32_t, 6> ropes;  ///< node behind each face, low faces first; core::kNone outside the tree
    std::uint32_t first, count;
  };
  const KdTree& tree;
  std::vector<KdNode> nodes;
  std::vector<Leaf> leaves;

  explicit KdTreeWithRopes(const KdTree& kd);
  std::span<const std::uint32_t> triangles_of(const Leaf& leaf) const {
    return {tree.triangles.data() + leaf.first, leaf.count};
  }
  std::size_t bytes() const {
    return nodes.size() * sizeof(KdNode) + leaves.size() * sizeof(Leaf) + tree.triangles.size() * sizeof(std::uint32_t);
  }
};

}  // namespace sightline::study::rays
