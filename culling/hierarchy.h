// The hierarchy that culling walks: blocks of slots. Leaf l spans slots 32 l … 32 l + 31, a node of level 0 sixteen
// leaves, a node of level j sixteen nodes of level j - 1. Nothing but boxes is stored: the structure follows from the
// number of slots, and quality from their order (core::build_bvh splits at such blocks). Sixteen boxes lie side by
// side. (Compare I. Wald, C. Benthin, S. Boulos, "Getting rid of packets", 2008, for wide nodes.)
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/item_bounds.h"
#include "sightline/culling/frustum_test.h"

namespace sightline::culling {

/// Boxes tested at a time: children of a node.
inline constexpr int kLanes = 16;
/// Slots per leaf.
inline constexpr std::uint32_t kLeafSize = 32;

/// Boxes of sixteen children, a cache line per coordinate: min x, min y, min z, max x, max y, max z. Unused lanes are
/// empty.
struct alignas(64) HierarchyNode {
  float bounds[6][kLanes];
};
static_assert(sizeof(HierarchyNode) == 384);

/// Layers below each child of the node of the same index. Items with an empty box count as being on no layer.
struct LayerNode {
  std::uint32_t any[kLanes];  ///< union of the items' layers
  std::uint32_t all[kLanes];  ///< intersection
  std::uint16_t some_hidden;  ///< bit per lane: some item is on no layer
};

class Hierarchy {
 public:
  Hierarchy() = default;
  /// Over the first `slot_count` slots of `bounds`, in whatever order they are.
  Hierarchy(const core::ItemBounds& bounds, std::size_t slot_count);

  /// Follows changed boxes and layers of the slots it covers. Linear time, no change of structure.
  void refit(const core::ItemBounds& bounds);

  bool empty() const { return nodes_.empty(); }
  std::uint32_t slot_count() const { return slot_count_; }
  int level_count() const { return int(first_node_.size()); }
  /// Level 0 holds the boxes of leaves; the last level is the root alone.
  std::span<const HierarchyNode> level(int level) const;
  /// False when every covered item is on core::kLayerModel alone and has a box: then no LayerNodes are kept.
  bool uses_layers() const { return !layers_.empty(); }
  /// Of the nodes of that level. Empty without layers.
  std::span<const LayerNode> layers(int level) const;
  /// Lanes in use over a whole level: leaves on level 0.
  std::uint32_t lane_count(int level) const;

  std::size_t node_count() const { return nodes_.size(); }
  std::size_t memory_bytes() const;

 private:
  std::size_t level_end(int level) const;
  void refit_boxes(const core::ItemBounds& bounds, bool& some_empty);
  void refit_layers(const core::ItemBounds& bounds);

  std::vector<HierarchyNode> nodes_;  // level 0 first
  std::vector<LayerNode> layers_;
  std::vector<std::size_t> first_node_;  // per level
  std::uint32_t slot_count_ = 0;
};

}  // namespace sightline::culling
