// Internal: leaves boxes out of a visible set that no ray of the image meets, as a test has it.
#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/internal/scratch.h"
#include "sightline/culling/occlusion/internal/filter_slots.h"
#include "sightline/culling/occlusion/internal/ray_queues.h"

namespace sightline::culling {

/// The answers for the boxes of a set. Boxes whose rays are still to be tested wait in queues.
struct Judgement {
  void add_group(unsigned unoccluded) { of_groups.push_back(std::uint16_t(unoccluded)); }
  void hide(const RayQueues::Place& place) { of_groups[place.group] &= std::uint16_t(~(1u << place.lane)); }
  std::uint32_t last_group() const { return std::uint32_t(of_groups.size() - 1); }
  /// Replaces `out` by the open slots of `in`, whose groups have been added.
  void list(const core::VisibleSet& in, core::VisibleSet& out) {
    std::size_t next = 0;
    for_each_slot_group(
        in, [&](const SlotGroup& group, bool of_range) { collector.add(group, of_groups[next++], of_range); });
    out.generation = in.generation;
    out.counters = in.counters;
    collector.finish(out);
    of_groups.clear();
  }
  std::size_t memory_bytes() const { return core::bytes_of(of_groups, collector); }

  std::vector<std::uint16_t> of_groups;  // bits of open boxes
  RayQueues queues;
  SlotCollector collector;
};

/// Bit i: box i of sixteen is not hidden. Test: as filter_boxes() has it.
template <class Test>
unsigned unoccluded_of(const Test& depth, const float* const (&coordinates)[6]) {
  BoxRectangles r;
  unsigned found = depth.maybe_unoccluded(coordinates, r);
  for (unsigned bits = depth.undecided(coordinates, r, found); bits != 0; bits &= bits - 1) {
    const int i = std::countr_zero(bits);
    if (depth.hides(box_of(coordinates, i), depth.pixels(r, i), r.nearest[i])) found &= ~(1u << i);
  }
  return found;
}

/// Replaces `unoccluded` by the slots of `in` that are not hidden, or exempt. Test: with the functions of DepthTest
/// that are called here.
template <class Test>
void filter_boxes(const Test& depth, const core::ItemBounds& bounds, const core::VisibleSet& in,
                  core::VisibleSet& unoccluded, SlotBits exempt) {
  const core::Scratch<Judgement> scratch;
  Judgement& judged = *scratch;
  const auto test = [&](const SmallBoxes& boxes, std::span<const RayQueues::Place> places) {
    const unsigned found = depth.unoccluded_boxes(boxes);
    for (std::size_t i = 0; i < places.size(); ++i)
      if ((found >> i & 1u) == 0) judged.hide(places[i]);
  };
  for_each_group(bounds, in, [&](const SlotGroup& group, unsigned used, bool) {
    BoxRectangles r;
    const unsigned spared = bits_in(exempt, group);
    const unsigned maybe = depth.maybe_unoccluded(group.coordinates, r) & used;
    judged.add_group(maybe | spared);
    for (unsigned bits = depth.undecided(group.coordinates, r, maybe) & ~spared; bits != 0; bits &= bits - 1) {
      const int i = std::countr_zero(bits);
      const RayQueues::Place place{judged.last_group(), i, group.slots[i]};
      const BoxCoordinates box = box_of(group.coordinates, i);
      const PixelRectangle pixels = depth.pixels(r, i);
      if (depth.waits(pixels))
        judged.queues.add(box, pixels, place, test);
      else if (depth.hides(box, pixels, r.nearest[i]))
        judged.hide(place);
    }
  });
  judged.queues.finish(test);
  judged.list(in, unoccluded);
}

}  // namespace sightline::culling
