#include "sightline/raytrace/internal/item_trees.h"

#include <algorithm>
#include <numeric>

#include "sightline/raytrace/internal/wide_tree.h"

namespace sightline::raytrace {
namespace {

using core::Aabb;
using core::kNone;
using core::Slot;

Aabb lane_box(const WideNode& node, std::uint32_t lane) {
  const auto& b = node.bounds;
  return {{b[0][lane], b[1][lane], b[2][lane]}, {b[3][lane], b[4][lane], b[5][lane]}};
}
void set_lane_box(WideNode& node, std::uint32_t lane, const Aabb& box) {
  for (int axis = 0; axis < 3; ++axis) {
    node.bounds[axis][lane] = box.min[axis];
    node.bounds[axis + 3][lane] = box.max[axis];
  }
}
Aabb box_of(const WideNode& node) {
  Aabb box;
  for (std::uint32_t lane = 0; lane < kLanes; ++lane) box.grow(lane_box(node, lane));
  return box;
}
bool same(const Aabb& a, const Aabb& b) {
  return a.min == b.min && a.max == b.max;
}

}  // namespace

ItemTrees::ItemTrees(const core::ItemBounds& bounds, int threads, const std::stop_token& stop) {
  places_.resize(bounds.size(), kNone);
  std::vector<Slot> slots(bounds.size());
  std::iota(slots.begin(), slots.end(), 0u);
  add(bounds, std::move(slots), threads, stop);
}

void ItemTrees::update(const core::ItemBounds& bounds, std::span<const Slot> changed) {
  const std::size_t former = places_.size();
  places_.resize(bounds.size(), kNone);
  std::vector<Slot> fresh;
  for (const Slot slot : changed) {
    if (slot >= former) continue;
    if (places_[slot] != kNone)
      refit(places_[slot], bounds.box(slot));
    else
      fresh.push_back(slot);
  }
  for (Tree& tree : trees_) measure(tree);
  for (std::size_t slot = former; slot < bounds.size(); ++slot) fresh.push_back(Slot(slot));
  std::erase_if(fresh, [&](Slot slot) { return bounds.vacant(slot); });
  if (fresh.empty()) return;
  while (!trees_.empty() && kLanes * (nodes_.size() - trees_.back().root) <= 4 * fresh.size() + kLanes)
    take_apart_last(fresh);
  add(bounds, std::move(fresh), 1);
}

/// Adds a tree over those of the slots that are not vacant.
void ItemTrees::add(const core::ItemBounds& bounds, std::vector<Slot> slots, int threads, const std::stop_token& stop) {
  core::LargeArray<BoxRef> refs;
  refs.reserve(slots.size());
  for (const Slot slot : slots) {
    if (looks_for_stop(slot) && stop.stop_requested()) return;
    if (bounds.vacant(slot)) continue;
    const Aabb box = bounds.box(slot);
    refs.push_back({{box.min.x, box.min.y, box.min.z}, slot, {box.max.x, box.max.y, box.max.z}});
  }
  if (refs.empty()) return;
  // Copying all nodes because an edit appends some would take a hundred times as long as the edit.
  const std::size_t spare_nodes = nodes_.empty() ? refs.size() / 50 : 0;
  BuiltTree built = build_wide_tree(refs, 1, threads, spare_nodes, stop);
  if (stop.stop_requested()) return;
  if (built.nodes.empty()) {  // one box
    WideNode& node = built.nodes.emplace_back();
    for (std::uint32_t lane = 0; lane < kLanes; ++lane) set_lane_box(node, lane, Aabb{});
    set_lane_box(node, 0, bounds.box(refs[0].id));
    std::fill_n(node.children, kLanes, kNone);
    node.children[0] = kLeafBit;
    node.parent = kNone;
  }
  const auto first = std::uint32_t(nodes_.size());
  for (std::uint32_t i = 0; i < built.nodes.size(); ++i) {
    if (looks_for_stop(i) && stop.stop_requested()) return;
    WideNode& node = built.nodes[i];
    if (node.parent != kNone) node.parent += first * kLanes;
    for (std::uint32_t lane = 0; lane < kLanes; ++lane) {
      std::uint32_t& child = node.children[lane];
      if (child == kNone) continue;
      if ((child & kLeafBit) == 0) {
        child += first;
        continue;
      }
      const Slot slot = refs[built.leaves[child & ~kLeafBit].first].id;
      child = kLeafBit | slot;
      places_[slot] = (first + i) * kLanes + lane;
    }
  }
  if (nodes_.empty())
    nodes_ = std::move(built.nodes);
  else
    nodes_.insert(nodes_.end(), built.nodes.begin(), built.nodes.end());
  measure(trees_.emplace_back(Tree{first, {}, refs.size() == 1 ? refs[0].id : kNone}));
}

/// Adds the slots of the last tree to `slots`.
void ItemTrees::take_apart_last(std::vector<Slot>& slots) {
  for (std::size_t i = trees_.back().root; i < nodes_.size(); ++i)
    for (const std::uint32_t child : nodes_[i].children)
      if (child != kNone && (child & kLeafBit) != 0) {
        slots.push_back(child & ~kLeafBit);
        places_[slots.back()] = kNone;
      }
  nodes_.resize(trees_.back().root);
  trees_.pop_back();
}

void ItemTrees::refit(std::uint32_t place, const Aabb& box) {
  Aabb fitted = box;
  while (place != kNone) {
    WideNode& node = nodes_[place / kLanes];
    if (same(lane_box(node, place % kLanes), fitted)) return;
    set_lane_box(node, place % kLanes, fitted);
    fitted = box_of(node);
    place = node.parent;
  }
}

void ItemTrees::measure(Tree& tree) const {
  const Aabb box = box_of(nodes_[tree.root]);
  tree.space = box.empty() ? TreeSpace{} : space_around({dvec3(box.min), dvec3(box.max)});
}

}  // namespace sightline::raytrace
