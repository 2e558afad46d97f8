#include "sightline/culling/cull_states.h"

#include <algorithm>
#include <utility>

#include "sightline/culling/frustum/frustum_test.h"

namespace sightline::culling {
namespace {

using core::Slot;

constexpr std::uint8_t kNothing = 0xfe, kMixed = 0xff;  // beside states: no items; of several states, or drawn

/// One lane of a node: what lies below it.
struct Lane {
  int level;
  std::uint32_t index;
};

class Sorting {
 public:
  Sorting(const core::View& view, const core::ItemBounds& bounds, const Hierarchy& hierarchy, SlotBits small,
          SlotBits occluded, CullStates& states)
      : planes_(view, bounds),
        layers_(view.layers),
        bounds_(bounds),
        hierarchy_(hierarchy),
        small_(small),
        occluded_(occluded),
        states_(states) {}

  void sort() {
    for_each_top([&](const Lane& lane) { walk(lane, planes_.all()); });
    if (small_.empty() && occluded_.empty()) return;
    uniform_.resize(std::size_t(hierarchy_.level_count()));
    for (int level = 0; level < hierarchy_.level_count(); ++level) {
      auto& of_level = uniform_[std::size_t(level)];
      for (std::uint32_t i = 0; i < hierarchy_.lane_count(level); ++i) of_level.push_back(uniform({level, i}));
    }
    for_each_top([&](const Lane& lane) { gather(lane); });
  }

 private:
  /// As a culler walks, but depth first.
  void walk(const Lane& lane, PlaneMask mask) {
    const core::Aabb box = hierarchy_.box(lane.level, lane.index);
    const auto [any_layer, all_layers] = layers_of(lane);
    if (planes_.nothing_visible() || planes_.outside(box, mask) || !any_layer)
      return add_node(lane, box, CullState::kOutside);
    const PlaneMask left = planes_.remaining(box, mask);
    if (left == 0 && all_layers) return add_node(lane, box, CullState::kInside);
    if (lane.level > 0) return for_each_child(lane, [&](const Lane& child) { walk(child, left); });
    for_each_slot(lane, [&](Slot slot) { add_item(slot, left); });
  }

  template <class Visit>
  void for_each_top(const Visit& visit) const {
    const int top = hierarchy_.level_count() - 1;
    for (std::uint32_t i = 0; top >= 0 && i < hierarchy_.lane_count(top); ++i) visit({top, i});
  }
  /// Whether any of the items, and whether all of them, are on a layer that the view shows.
  std::pair<bool, bool> layers_of(const Lane& lane) const {
    const bool model = (core::kLayerModel & layers_) != 0;
    if (!hierarchy_.uses_layers()) return {model, model};
    const LayerNode& node = hierarchy_.layers(lane.level)[lane.index / kLanes];
    const std::uint32_t i = lane.index % kLanes;
    return {(node.any[i] & layers_) != 0, (node.all[i] & layers_) != 0};
  }
  template <class Visit>
  void for_each_child(const Lane& lane, const Visit& visit) const {
    const std::uint32_t end = std::min((lane.index + 1) * kLanes, hierarchy_.lane_count(lane.level - 1));
    for (std::uint32_t i = lane.index * kLanes; i < end; ++i) visit({lane.level - 1, i});
  }
  /// Slots that are not vacant.
  template <class Visit>
  void for_each_slot(const Lane& lane, const Visit& visit) const {
    std::uint64_t size = kLeafSize;
    for (int level = 0; level < lane.level; ++level) size *= kLanes;
    const std::uint64_t end = std::min<std::uint64_t>((lane.index + 1) * size, hierarchy_.slot_count());
    for (std::uint64_t slot = lane.index * size; slot < end; ++slot)
      if (!bounds_.vacant(slot)) visit(Slot(slot));
  }

  CullState set(Slot slot, CullState by_box) {
    CullState state = by_box;
    if (by_box != CullState::kOutside && contains(small_, slot))
      state = CullState::kTooSmall;
    else if (by_box != CullState::kOutside && contains(occluded_, slot))
      state = CullState::kOccluded;
    states_.of_slot[slot] = state;
    ++states_.items[std::size_t(state)];
    return state;
  }
  void add_node(const Lane& lane, const core::Aabb& box, CullState state) {
    std::uint32_t items = 0;
    for_each_slot(lane, [&](Slot slot) { items += set(slot, state) == state; });
    if (items > 0) states_.boxes.push_back({box, state, items});
  }
  void add_item(Slot slot, PlaneMask mask) {
    const core::Aabb box = bounds_.box(slot);
    CullState state = CullState::kIntersecting;
    if ((bounds_.layers(slot) & layers_) == 0 || !planes_.visible(box, mask))
      state = CullState::kOutside;
    else if (planes_.remaining(box, mask) == 0)
      state = CullState::kInside;
    if (set(slot, state) == state) states_.boxes.push_back({box, state, 1});
  }

  static bool is_left_out(CullState state) { return state == CullState::kOccluded || state == CullState::kTooSmall; }
  std::uint8_t uniform(const Lane& lane) const {
    std::uint8_t all = kNothing;
    const auto add = [&](std::uint8_t state) {
      if (state != kNothing) all = all == kNothing || all == state ? state : kMixed;
    };
    if (lane.level > 0)
      for_each_child(lane, [&](const Lane& child) { add(uniform_of(child)); });
    else
      for_each_slot(lane, [&](Slot slot) {
        const CullState state = states_.of_slot[slot];
        add(is_left_out(state) ? std::uint8_t(state) : kMixed);
      });
    return all;
  }
  std::uint8_t uniform_of(const Lane& lane) const { return uniform_[std::size_t(lane.level)][lane.index]; }
  /// The largest nodes, and single items, of all that is left out in the view volume.
  void gather(const Lane& lane) {
    const std::uint8_t all = uniform_of(lane);
    if (all == kNothing) return;
    if (all != kMixed) {
      std::uint32_t items = 0;
      for_each_slot(lane, [&](Slot) { ++items; });
      states_.boxes.push_back({hierarchy_.box(lane.level, lane.index), CullState(all), items});
    } else if (lane.level > 0) {
      for_each_child(lane, [&](const Lane& child) { gather(child); });
    } else {
      for_each_slot(lane, [&](Slot slot) {
        const CullState state = states_.of_slot[slot];
        if (is_left_out(state)) states_.boxes.push_back({bounds_.box(slot), state, 1});
      });
    }
  }

  const CullPlanes planes_;
  const std::uint32_t layers_;
  const core::ItemBounds& bounds_;
  const Hierarchy& hierarchy_;
  const SlotBits small_, occluded_;
  CullStates& states_;
  std::vector<std::vector<std::uint8_t>> uniform_;  // of each lane of each level: a state, kNothing or kMixed
};

}  // namespace

CullStates cull_states(const core::View& view, const core::ItemBounds& bounds, const Hierarchy& hierarchy,
                       SlotBits small, SlotBits occluded) {
  CullStates states;
  states.of_slot.assign(bounds.size(), CullState::kOutside);
  Sorting(view, bounds, hierarchy, small, occluded, states).sort();
  return states;
}

}  // namespace sightline::culling
