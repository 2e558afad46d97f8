#include "sightline/culling/frustum/cpu_culler.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <memory>
#include <span>

#include "sightline/core/internal/scratch.h"
#include "sightline/culling/frustum/frustum_test.h"
#include "sightline/culling/frustum/internal/kernels.h"

namespace sightline::culling {
namespace {

constexpr int kMaxLevels = 8;  // 32 * 16^7 slots exceed 2^32

/// Memory that grows and is never cleared, so that pages of work queues that no view fills are never touched.
template <class T>
class Buffer {
 public:
  T* reserve(std::size_t count) {
    if (count > size_) {
      data_ = std::make_unique_for_overwrite<T[]>(count);
      size_ = count;
    }
    return data_.get();
  }
  std::size_t memory_bytes() const { return size_ * sizeof(T); }

 private:
  std::unique_ptr<T[]> data_;
  std::size_t size_ = 0;
};

struct TraversalBuffers {
  Buffer<std::uint32_t> node_queues[2], leaf_queue, leaf_masks, items, edges;
  Buffer<Crossing> crossings[2], leaf_crossings;
  Buffer<std::uint16_t> marks;

  std::size_t memory_bytes() const {
    return core::bytes_of(node_queues[0], node_queues[1], leaf_queue, leaf_masks, items, edges, crossings[0],
                          crossings[1], leaf_crossings, marks);
  }
};

/// Queues have room for one whole level, and for sixteen lanes more, since kernels write whole groups.
void provide_memory(TraversalBuffers& buffers, TraversalInput& in, std::size_t leaves) {
  const std::size_t nodes = in.levels[0].count;
  in.stride = nodes + kLanes;
  for (int i = 0; i < 2; ++i) {
    in.node_queues[i] = buffers.node_queues[i].reserve(in.stride * kMaxCullPlanes);
    in.crossings[i] = buffers.crossings[i].reserve(in.stride);
  }
  in.leaf_stride = leaves + kLanes;
  in.leaf_queue = buffers.leaf_queue.reserve(in.leaf_stride * kMaxCullPlanes);
  in.leaf_crossings = buffers.leaf_crossings.reserve(leaves + kLanes);
  in.leaf_masks = buffers.leaf_masks.reserve(leaves);
  const std::size_t padded = (nodes / kLanes + 1) * kLanes;
  in.inside = buffers.marks.reserve(3 * padded);
  in.partial = in.inside + padded;
  in.toggles = in.partial + padded;
  std::fill_n(in.inside, 2 * padded + padded / kLanes + 1, std::uint16_t(0));
}

/// Turns leaves at which ranges begin and end into ranges of slots.
void append_ranges(std::span<const core::Slot> edges, std::uint32_t slot_count, std::vector<core::SlotRange>& ranges) {
  ranges.resize(edges.size() / 2);
  for (std::size_t i = 0; i < ranges.size(); ++i)
    ranges[i] = {edges[2 * i] * kLeafSize, (edges[2 * i + 1] - edges[2 * i]) * kLeafSize};
  if (!ranges.empty()) ranges.back().count = std::min(ranges.back().count, slot_count - ranges.back().first);
}

void cull_tree(const core::ItemBounds& bounds, const Hierarchy& hierarchy, const CullPlanes& planes,
               std::uint32_t layers, core::VisibleSet& set) {
  std::array<LevelView, kMaxLevels> levels;
  TraversalInput in{};
  for (int i = 0; i < hierarchy.level_count(); ++i) {
    const auto nodes = hierarchy.level(i);
    const std::uint32_t last = hierarchy.lane_count(i) - std::uint32_t(nodes.size() - 1) * kLanes;
    levels[std::size_t(i)] = {nodes.data(), hierarchy.uses_layers() ? hierarchy.layers(i).data() : nullptr,
                              std::uint32_t(nodes.size()), (1u << last) - 1u};
  }
  in.test = make_item_test(bounds, planes, layers);
  in.all_planes = planes.all();
  in.levels = levels.data();
  in.level_count = hierarchy.level_count();
  in.slot_count = hierarchy.slot_count();
  const core::Scratch<TraversalBuffers> scratch;
  provide_memory(*scratch, in, hierarchy.lane_count(0));

  const FrustumKernels& kernel = frustum_kernels();
  kernel.traverse(in);
  set.counters.nodes_tested += in.nodes_tested;
  set.counters.boxes_tested += in.boxes_tested;

  const std::size_t leaves = hierarchy.lane_count(0);
  const FoundSlots begin{scratch->items.reserve((leaves + 1) * kLeafSize), scratch->edges.reserve(leaves + 4 * kLanes)};
  FoundSlots end = begin;
  kernel.extract(in, end);
  set.single_slots.assign(begin.items, end.items);
  append_ranges({begin.edges, end.edges}, in.slot_count, set.ranges);
}

}  // namespace

CpuCuller::CpuCuller(const core::ItemBounds& bounds) : bounds_(&bounds), hierarchy_(bounds) {}

void CpuCuller::cull(const core::View& view, core::VisibleSet& set) const {
  set.clear();
  const CullPlanes planes(view, *bounds_);
  if (planes.nothing_visible()) return;
  // Without layer nodes every item is on the model layer alone.
  if (hierarchy_.empty() || (!hierarchy_.uses_layers() && (view.layers & core::kLayerModel) == 0)) return;
  // A view of everything needs no walk, whose fixed cost grows with the scene.
  if (!hierarchy_.uses_layers() && planes.remaining(bounds_->extent(), planes.all()) == 0) {
    set.counters.nodes_tested = 1;
    set.ranges.push_back({0, hierarchy_.slot_count()});
    return;
  }
  cull_tree(*bounds_, hierarchy_, planes, view.layers, set);
}

void CpuCuller::cull(std::span<const core::View> views, std::span<core::VisibleSet> sets,
                     core::ThreadPool* threads) const {
  assert(sets.size() >= views.size());
  core::ThreadPool::run_on(threads, std::uint32_t(views.size()), [&](std::uint32_t i) { cull(views[i], sets[i]); });
}

}  // namespace sightline::culling
