#include "sightline/culling/cpu_culler.h"

#include <array>
#include <bit>
#include <cassert>
#include <vector>

#include "sightline/culling/frustum_test.h"
#include "sightline/culling/linear_culler.h"

namespace sightline::culling {
namespace {

/// Trees of core::build_bvh stay below this; deeper ones of other makers take their stack from the heap.
constexpr std::size_t kUsualDepth = 112;

/// A node on the way down: its children are handled in slot order, and taken up again after each descent.
struct Frame {
  const HierarchyNode* node;
  std::uint32_t end;      // of the node's slots
  unsigned pending;       // bit per lane: visible and not yet handled
  unsigned layers_clear;  // bit per lane: every item below is on a layer of the view
  LaneResult tested;
};

/// One walk through the hierarchy for one view.
class Walk {
 public:
  Walk(const core::ItemBounds& bounds, const Hierarchy& hierarchy, const CullPlanes& planes, std::uint32_t layers,
       core::VisibleSet& set)
      : bounds_(bounds), hierarchy_(hierarchy), planes_(planes), layers_(layers), set_(set) {}

  void run(Frame* stack) {
    Frame* top = stack;
    enter(*top, hierarchy_.root(), hierarchy_.slot_count(), planes_.all());
    for (;;) {
      while (top->pending == 0) {
        if (top == stack) return;
        --top;
      }
      const int lane = std::countr_zero(top->pending);
      top->pending &= top->pending - 1;
      const HierarchyNode& node = *top->node;
      const PlaneMask mask = top->tested.mask[std::size_t(lane)];
      const std::uint32_t first = node.first[lane], end = lane + 1 < kLanes ? node.first[lane + 1] : top->end;
      if (mask == 0 && (top->layers_clear >> lane & 1u) != 0) {
        emit(first, end);
      } else if (node.child[lane].is_leaf()) {
        cull_slots(bounds_, planes_, mask, layers_, first, end, set_);
      } else {
        enter(*++top, node.child[lane], end, mask);
      }
    }
  }

 private:
  void enter(Frame& frame, ChildRef child, std::uint32_t end, PlaneMask mask) {
    const unsigned used = (1u << child.lanes()) - 1u;
    frame.node = &hierarchy_.node(child.index());
    frame.end = end;
    frame.layers_clear = used;
    if (mask != 0) {
      set_.counters.nodes_tested += unsigned(child.lanes());
      planes_.classify(frame.node->bounds, mask, frame.tested);
      frame.pending = used & ~frame.tested.outside;
    } else {
      frame.tested.mask.fill(0);
      frame.pending = used;
    }
    if (hierarchy_.uses_layers()) look_at_layers(frame, hierarchy_.layers(child.index()));
  }

  void look_at_layers(Frame& frame, const LayerNode& layers) const {
    frame.layers_clear = 0;
    for (unsigned rest = frame.pending; rest != 0; rest &= rest - 1) {
      const int i = std::countr_zero(rest);
      const bool hidden = (layers.some_hidden >> i & 1u) != 0;
      if ((layers.any[i] & layers_) == 0) frame.pending &= ~(1u << i);
      if ((layers.all[i] & layers_) != 0 || (!hidden && (layers.any[i] & ~layers_) == 0)) frame.layers_clear |= 1u << i;
    }
  }

  void emit(std::uint32_t first, std::uint32_t end) {
    if (!set_.ranges.empty()) {
      core::SlotRange& last = set_.ranges.back();
      if (last.first + last.count == first) {
        last.count += end - first;
        return;
      }
    }
    set_.ranges.push_back({first, end - first});
  }

  const core::ItemBounds& bounds_;
  const Hierarchy& hierarchy_;
  const CullPlanes& planes_;
  std::uint32_t layers_;
  core::VisibleSet& set_;
};

}  // namespace

CpuCuller::CpuCuller(const core::ItemBounds& bounds, const core::BvhTree& tree, std::size_t tree_size)
    : bounds_(&bounds), hierarchy_(bounds, tree) {
  assert(tree_size == hierarchy_.slot_count());
  (void)tree_size;
}

void CpuCuller::cull(const core::View& view, core::VisibleSet& set) const {
  set.clear();
  const CullPlanes planes(view, *bounds_);
  if (planes.nothing_visible()) return;
  // Without layer nodes every item of the tree is on the model layer alone.
  const bool skip_tree = !hierarchy_.uses_layers() && (view.layers & core::kLayerModel) == 0;
  if (!hierarchy_.empty() && !skip_tree) {
    Walk walk(*bounds_, hierarchy_, planes, view.layers, set);
    if (hierarchy_.depth() <= kUsualDepth) {
      std::array<Frame, kUsualDepth> stack;
      walk.run(stack.data());
    } else {
      std::vector<Frame> stack(hierarchy_.depth());
      walk.run(stack.data());
    }
  }
  cull_slots(*bounds_, planes, planes.all(), view.layers, hierarchy_.slot_count(), bounds_->size(), set);
}

}  // namespace sightline::culling
