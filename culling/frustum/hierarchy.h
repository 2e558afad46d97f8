// The hierarchy that culling walks: blocks of slots. Leaf l spans slots 32 l … 32 l + 31, a node of level 0 sixteen
// leaves, a node of level j sixteen nodes of level j - 1. Only boxes are stored. The structure follows from the number
// of slots, and its quality from their order (core::block_order). Sixteen boxes lie side by side. (Compare I. Wald, C.
// Benthin, S. Boulos, "Getting rid of packets", 2008, for wide nodes.)
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/api.h"
#include "sightline/core/item_bounds.h"
#include "sightline/core/thread_pool.h"
#include "sightline/culling/frustum/frustum_test.h"

namespace sightline::culling {

/// Boxes tested at a time: children of a node.
inline constexpr int kLanes = 16;
/// Slots per leaf.
inline constexpr std::uint32_t kLeafSize = core::kBlockSlots;

/// Boxes of sixteen children, a cache line per coordinate: min x, min y, min z, max x, max y, max z. Unused lanes are
/// empty.
struct alignas(64) HierarchyNode {
  float bounds[6][kLanes];
};
static_assert(sizeof(HierarchyNode) == 384);

/// Layers below each child of the node of the same index. Vacant slots do not count.
struct LayerNode {
  std::uint32_t any[kLanes];  ///< union of the items' layers
  std::uint32_t all[kLanes];  ///< intersection
};

class SIGHTLINE_API Hierarchy {
 public:
  Hierarchy() = default;
  /// Over all slots of `bounds`, in any order.
  explicit Hierarchy(const core::ItemBounds& bounds) { refit(bounds); }

  /// Refits all boxes, after any change of the bounds. Linear time. With `threads`, subtrees are distributed among them
  /// where that is faster.
  void refit(const core::ItemBounds& bounds, core::ThreadPool* threads = nullptr);
  /// Follows changes of boxes or layers of `changed` slots alone (in any order, repeated or not) and slots were
  /// appended. Refits only their blocks and the nodes above them. Boxes around slots that became vacant keep their
  /// sizes, so a walk may go further than needed. Each changed block and each node above is refitted once. Linear in
  /// the number of changes; does not depend on the number of slots unless slots were appended.
  void update(const core::ItemBounds& bounds, std::span<const core::Slot> changed, core::ThreadPool* threads = nullptr);

  bool empty() const { return slot_count_ == 0; }
  std::uint32_t slot_count() const { return slot_count_; }
  int level_count() const { return int(nodes_.size()); }
  /// Level 0 holds the boxes of leaves; the last level is the root alone.
  std::span<const HierarchyNode> level(int level) const { return nodes_[std::size_t(level)]; }
  /// The box of a lane: child `lane` % kLanes of node `lane` / kLanes of that level.
  core::Aabb box(int level, std::uint32_t lane) const {
    const auto& bounds = nodes_[std::size_t(level)][lane / kLanes].bounds;
    const auto at = [&](int side) { return bounds[side][lane % kLanes]; };
    return {{at(0), at(1), at(2)}, {at(3), at(4), at(5)}};
  }
  /// False when every item is on core::kLayerModel alone: then no LayerNodes are kept.
  bool uses_layers() const { return !layers_.empty(); }
  /// Layers of the nodes of that level. Empty without layers.
  std::span<const LayerNode> layers(int level) const {
    return layers_.empty() ? std::span<const LayerNode>() : layers_[std::size_t(level)];
  }
  /// Lanes in use over a whole level: leaves on level 0.
  std::uint32_t lane_count(int level) const;

  std::size_t node_count() const;
  std::size_t memory_bytes() const;

 private:
  void resize(const core::ItemBounds& bounds);
  void mark(std::uint32_t leaf);
  void mark_all(int level);
  void refit_lane(const core::ItemBounds& bounds, int level, std::uint32_t lane);
  void refit_marked(const core::ItemBounds& bounds, int level, std::uint32_t node);
  void refit_marked(const core::ItemBounds& bounds, core::ThreadPool* threads);

  std::vector<core::LargeArray<HierarchyNode>> nodes_;  // per level
  std::vector<core::LargeArray<LayerNode>> layers_;     // per level; none without layers
  std::vector<std::vector<std::uint16_t>> marks_;       // per level, of each node: bit per lane to be refitted
  std::uint32_t slot_count_ = 0;
};

}  // namespace sightline::culling
