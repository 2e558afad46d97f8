// The hierarchy that culling walks: eight boxes per node, side by side, so that one node is one group of SIMD lanes.
// Collapsed from the binary tree that ordered the snapshot, hence every child is a contiguous range of slots.
// (I. Wald, C. Benthin, S. Boulos, "Getting rid of packets: efficient SIMD single-ray traversal using multi-branching
// BVHs", 2008: the greedy collapse by surface area.)
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "sightline/core/bvh_build.h"
#include "sightline/core/item_bounds.h"
#include "sightline/culling/frustum_test.h"

namespace sightline::culling {

/// What a child is: slots tested one by one from the bounds, or another node. Unused lanes are leaves without slots.
class ChildRef {
 public:
  ChildRef() = default;
  static ChildRef leaf(std::uint32_t count) { return ChildRef(kLeafBit | count); }
  static ChildRef node(std::uint32_t index, int lanes) {
    return ChildRef(std::uint32_t(lanes - 1) << kIndexBits | index);
  }
  bool is_leaf() const { return (bits_ & kLeafBit) != 0; }
  std::uint32_t leaf_count() const { return bits_ & ~kLeafBit; }
  std::uint32_t index() const { return bits_ & ((1u << kIndexBits) - 1); }  ///< of the node
  int lanes() const { return int(bits_ >> kIndexBits) + 1; }                ///< how many of the node's lanes are used

 private:
  static constexpr std::uint32_t kLeafBit = 1u << 31;
  static constexpr int kIndexBits = 28;
  explicit ChildRef(std::uint32_t bits) : bits_(bits) {}
  std::uint32_t bits_ = kLeafBit;
};

/// Four cache lines. Children are in slot order, used lanes first; child i covers slots first[i] … first[i + 1] - 1,
/// the last one up to the end of the node's own range, which whoever came here knows. first[] of unused lanes is that
/// end.
struct alignas(64) HierarchyNode {
  BoxLanes bounds;
  ChildRef child[kLanes];
  std::uint32_t first[kLanes];
};
static_assert(sizeof(HierarchyNode) == 256);

/// Layers below each child of the node of the same index. Items with an empty box count as being on no layer.
struct LayerNode {
  std::uint32_t any[kLanes];  ///< union of the items' layers
  std::uint32_t all[kLanes];  ///< intersection
  std::uint8_t some_hidden;   ///< bit per lane: some item is on no layer
};

class Hierarchy {
 public:
  Hierarchy() = default;
  /// `tree` covers the first slots of `bounds`; subtrees of up to kLanes slots become leaves. Iterative.
  Hierarchy(const core::ItemBounds& bounds, const core::BvhTree& tree);

  /// Follows changed boxes and layers of the slots it covers. Linear time, no change of structure.
  void refit(const core::ItemBounds& bounds);

  bool empty() const { return nodes_.empty(); }
  ChildRef root() const { return root_; }
  std::uint32_t slot_count() const { return slot_count_; }
  const HierarchyNode& node(std::uint32_t index) const { return nodes_[index]; }
  /// False when every covered item is on core::kLayerModel alone and has a box: then no LayerNodes are kept.
  bool uses_layers() const { return !layers_.empty(); }
  const LayerNode& layers(std::uint32_t index) const { return layers_[index]; }

  std::size_t node_count() const { return nodes_.size(); }
  std::uint32_t depth() const { return depth_; }  ///< nodes on the longest way down; at most the tree's depth + 1
  std::size_t memory_bytes() const;

 private:
  struct Collapse;
  void refit_boxes(const core::ItemBounds& bounds, bool& some_empty);
  void refit_layers(const core::ItemBounds& bounds);

  std::vector<HierarchyNode> nodes_;  // children after their parent
  std::vector<LayerNode> layers_;
  ChildRef root_;
  std::uint32_t slot_count_ = 0, depth_ = 0;
};

}  // namespace sightline::culling
