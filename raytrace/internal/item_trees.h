// Hierarchies over the items of a snapshot. Internal to raytrace.
#pragma once

#include <span>
#include <stop_token>
#include <vector>

#include "sightline/core/item_bounds.h"
#include "sightline/core/large_array.h"
#include "sightline/raytrace/internal/ray_frame.h"
#include "sightline/raytrace/internal/wide_node.h"

namespace sightline::raytrace {

/// One hierarchy over the slots that were there at first, and a few smaller ones over slots that came later. A new one
/// takes in those that are not larger than itself, so there are at most about log2 of the number of slots. (J. Bentley,
/// J. Saxe, "Decomposable searching problems", 1980.) Boxes are relative to the bounds' origin.
class ItemTrees {
 public:
  struct Tree {
    std::uint32_t root;  // nodes of a tree follow it, up to the next tree's root
    TreeSpace space;
    core::Slot only;  // the one item that it holds; kNone: there are several
  };

  ItemTrees() = default;
  /// `threads`, `stop`: see build_wide_tree(); there is then no tree.
  ItemTrees(const core::ItemBounds& bounds, int threads, const std::stop_token& stop = {});
  /// After changes of the boxes of `changed` slots, and after slots were appended.
  void update(const core::ItemBounds& bounds, std::span<const core::Slot> changed);

  const WideNode* nodes() const { return nodes_.data(); }
  std::span<const Tree> trees() const { return trees_; }
  std::size_t slot_count() const { return places_.size(); }  ///< at the last update
  std::size_t memory_bytes() const { return nodes_.size() * sizeof(WideNode) + places_.size() * 4; }

 private:
  void add(const core::ItemBounds& bounds, std::vector<core::Slot> slots, int threads,
           const std::stop_token& stop = {});
  void take_apart_last(std::vector<core::Slot>& slots);
  void refit(std::uint32_t place, const core::Aabb& box);
  void measure(Tree& tree) const;

  core::LargeArray<WideNode> nodes_;
  std::vector<Tree> trees_;
  core::LargeArray<std::uint32_t> places_;  // of each slot: kLanes * node + lane; kNone: in no tree
};

}  // namespace sightline::raytrace
