// Internal: leaves slots out of a visible set, sixteen boxes at a time.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <span>
#include <utility>
#include <vector>

#include "sightline/core/internal/intrinsics.h"
#include "sightline/core/internal/scratch.h"
#include "sightline/core/item_bounds.h"
#include "sightline/core/visible_set.h"
#include "sightline/culling/frustum/internal/append_range.h"
#include "sightline/culling/occlusion/internal/kernels.h"
#include "sightline/culling/occlusion/sample_test.h"

namespace sightline::culling {

/// Box i of sixteen.
inline BoxCoordinates box_of(const float* const (&coordinates)[6], int i) {
  const auto& c = coordinates;
  return {c[0][i], c[1][i], c[2][i], c[3][i], c[4][i], c[5][i]};
}

/// Pixels of the image with a sample in the rectangle of box i; offsets of the samples from the pixel centre. None
/// where x1 < x0 or y1 < y0. Without std::floor, which is a function call where the instruction set has no floor.
inline PixelRectangle pixels_of(const ScreenView& view, const BoxRectangles& r, int i, float offset_x = 0.0f,
                                float offset_y = 0.0f) {
  const float left = std::max(r.left[i] - offset_x, 0.0f), right = std::min(r.right[i] - offset_x, view.last_x);
  const float bottom = std::max(r.bottom[i] - offset_y, 0.0f), top = std::min(r.top[i] - offset_y, view.last_y);
  const auto next = [](float a) { return int(a) + (float(int(a)) < a); };
  const auto last = [](float a) { return a < 0.0f ? -1 : int(a); };
  return {next(left), next(bottom), last(right), last(top)};
}

/// Sixteen slots and their boxes.
struct SlotGroup {
  const float* coordinates[6];  // of the first slot, those of the others behind it
  core::Slot slots[kLanes];
  int count;  // of slots in use; the boxes behind them are any
};

/// Fetches the boxes of ranges a few groups before they are needed: the processor by itself does not foresee short
/// ranges in six arrays.
class PrefetchedRanges {
 public:
  PrefetchedRanges(const core::ItemBounds& bounds, std::span<const core::SlotRange> ranges)
      : bounds_(bounds), ranges_(ranges) {
    for (int i = 0; i < kAhead; ++i) prefetch_next();
  }
  void prefetch_next() {
    if (range_ == ranges_.size()) return;
    const core::SlotRange& range = ranges_[range_];
    for (int axis = 0; axis < 6; ++axis)
      core::prefetch_line<core::CacheLevel::kL1>(bounds_.coordinate(axis) + range.first + done_);
    done_ += kLanes;
    if (done_ >= range.count) ++range_, done_ = 0;
  }

 private:
  static constexpr int kAhead = 8;  // groups
  const core::ItemBounds& bounds_;
  std::span<const core::SlotRange> ranges_;
  std::size_t range_ = 0;
  std::uint32_t done_ = 0;
};

/// Calls visit(group, whether it is of a range) for all slots of `in`, sixteen at a time: first those of ranges, then
/// single slots, each in rising order. The groups have no boxes yet.
template <class Visit>
void for_each_slot_group(const core::VisibleSet& in, Visit&& visit) {
  SlotGroup group{};
  const auto count_of = [](std::size_t left) { return int(std::min<std::size_t>(kLanes, left)); };
  for (const core::SlotRange& range : in.ranges)
    for (core::Slot done = 0; done < range.count; done += kLanes) {
      group.count = count_of(range.count - done);
      for (int i = 0; i < kLanes; ++i) group.slots[i] = range.first + done + core::Slot(i);
      visit(group, true);
    }
  for (std::size_t done = 0; done < in.single_slots.size(); done += kLanes) {
    group.count = count_of(in.single_slots.size() - done);
    std::copy_n(in.single_slots.begin() + std::ptrdiff_t(done), group.count, group.slots);
    visit(group, false);
  }
}

/// Visits slots with their boxes: calls visit(group, bits of the slots in use, whether they are of a range). Single
/// slots have their boxes copied side by side.
template <class Visit>
void for_each_group(const core::ItemBounds& bounds, const core::VisibleSet& in, Visit&& visit) {
  PrefetchedRanges ahead(bounds, in.ranges);
  alignas(64) float boxes[6][kLanes] = {};
  for_each_slot_group(in, [&](SlotGroup& group, bool of_range) {
    if (of_range) {
      ahead.prefetch_next();
      for (int axis = 0; axis < 6; ++axis) group.coordinates[axis] = bounds.coordinate(axis) + group.slots[0];
    } else {
      for (int axis = 0; axis < 6; ++axis) group.coordinates[axis] = boxes[axis];
      for (int i = 0; i < group.count; ++i)
        for (int axis = 0; axis < 6; ++axis) boxes[axis][i] = bounds.coordinate(axis)[group.slots[i]];
    }
    visit(std::as_const(group), (1u << group.count) - 1u, of_range);
  });
}

/// Collects slots in the order of for_each_group() into a visible set.
class SlotCollector {
 public:
  /// Adds the slots of a group whose bits are set. Ranges stay ranges where all slots of a group are added.
  void add(const SlotGroup& group, unsigned bits, bool of_range) {
    if (of_range && bits != 0 && group.count == std::popcount(bits)) {
      append_range(group.slots[0], group.slots[0] + core::Slot(group.count), ranges_);
      return;
    }
    std::vector<core::Slot>& slots = of_range ? of_ranges_ : singles_;
    for (; bits != 0; bits &= bits - 1) slots.push_back(group.slots[std::countr_zero(bits)]);
  }
  /// Replaces the slots of `out` and begins anew.
  void finish(core::VisibleSet& out) {
    std::swap(out.ranges, ranges_);
    merge_slots(of_ranges_, singles_, out.single_slots);
    ranges_.clear();
    of_ranges_.clear();
    singles_.clear();
  }
  std::size_t memory_bytes() const { return core::bytes_of(ranges_, of_ranges_, singles_); }

 private:
  std::vector<core::SlotRange> ranges_;
  std::vector<core::Slot> of_ranges_, singles_;
};

/// Bit i: slot i of a group is in a set.
inline unsigned bits_in(SlotBits set, const SlotGroup& group) {
  unsigned bits = 0;
  for (int i = 0; i < group.count && !set.empty(); ++i) bits |= unsigned(contains(set, group.slots[i])) << i;
  return bits;
}

/// Replaces `out` by the slots of `in` that kept(coordinates of sixteen boxes) has a bit for, or `exempt`.
template <class Kept>
void filter_slots(const core::ItemBounds& bounds, const core::VisibleSet& in, core::VisibleSet& out, SlotBits exempt,
                  const Kept& kept) {
  const core::Scratch<SlotCollector> scratch;
  SlotCollector& collector = *scratch;
  for_each_group(bounds, in, [&](const SlotGroup& group, unsigned used, bool of_range) {
    collector.add(group, (kept(group.coordinates) & used) | bits_in(exempt, group), of_range);
  });
  collector.finish(out);
  out.generation = in.generation;
  out.counters = in.counters;
}

/// Which children of nodes are kept. What lies below one that is not is not kept either, and not tested. Remembers the
/// last node of each level, so nodes should be asked for in rising order.
template <class Kept>
class KeptNodes {
 public:
  KeptNodes(const Hierarchy& hierarchy, const Kept& kept_of) : hierarchy_(hierarchy), kept_of_(kept_of) {}

  /// Bit per child.
  unsigned children(int level, std::uint32_t node) {
    Known& known = known_[std::size_t(level)];
    if (known.node != node) known = {node, left_out(level, node) ? 0u : test(level, node)};
    return known.kept;
  }

 private:
  static constexpr std::size_t kMostLevels = 8;
  struct Known {
    std::uint32_t node = core::kNone;
    unsigned kept = 0;
  };

  bool left_out(int level, std::uint32_t node) {
    return level + 1 < hierarchy_.level_count() && (children(level + 1, node / kLanes) >> node % kLanes & 1u) == 0;
  }
  unsigned test(int level, std::uint32_t node) const {
    const float* coordinates[6];
    for (int axis = 0; axis < 6; ++axis) coordinates[axis] = hierarchy_.level(level)[node].bounds[axis];
    return kept_of_(coordinates);
  }

  const Hierarchy& hierarchy_;
  const Kept& kept_of_;
  std::array<Known, kMostLevels> known_;
};

/// Replaces `out` by `in` without those leaves within its ranges that kept(coordinates of sixteen leaves) has no bit
/// for, and that hold no slot of `exempt`.
template <class Kept>
void filter_leaves(const Hierarchy& hierarchy, const core::VisibleSet& in, core::VisibleSet& out, SlotBits exempt,
                   const Kept& kept) {
  static_assert(64 % kLeafSize == 0);
  out.clear();
  out.generation = in.generation;
  out.single_slots = in.single_slots;
  const auto append = [&](core::Slot first, core::Slot end) {
    if (first < end) append_range(first, end, out.ranges);
  };
  const auto spared = [&](std::uint32_t leaf) {
    const std::size_t slot = std::size_t(leaf) * kLeafSize, word = slot / 64;
    return word < exempt.size() && (exempt[word] >> slot % 64 & ((std::uint64_t(1) << kLeafSize) - 1)) != 0;
  };
  KeptNodes nodes(hierarchy, kept);
  for (const core::SlotRange& range : in.ranges) {
    const core::Slot end = range.first + range.count;
    const core::Slot begin = std::min(end, (range.first + kLeafSize - 1) / kLeafSize * kLeafSize);
    append(range.first, begin);
    for (core::Slot first = begin; first < end; first += kLeafSize) {
      const std::uint32_t leaf = first / kLeafSize;
      const unsigned bits = nodes.children(0, leaf / kLanes);
      if ((bits >> leaf % kLanes & 1u) != 0 || spared(leaf)) append(first, std::min(end, first + kLeafSize));
    }
  }
}

/// What a kernel finds for one box: bit 0 of found(coordinates of sixteen boxes, the first of which is `box`).
template <class Found>
bool of_one_box(const core::Aabb& box, const Found& found) {
  float coordinates[6][kLanes] = {};
  const float* arrays[6];
  for (int axis = 0; axis < 6; ++axis) {
    coordinates[axis][0] = axis < 3 ? box.min[axis] : box.max[axis - 3];
    arrays[axis] = coordinates[axis];
  }
  return (found(arrays) & 1u) != 0;
}

}  // namespace sightline::culling
