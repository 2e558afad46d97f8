#include "sightline/culling/occlusion/occlusion_test.h"

#include <algorithm>
#include <bit>

#include "sightline/core/internal/scratch.h"
#include "sightline/culling/frustum/internal/set_parts.h"
#include "sightline/culling/occlusion/internal/filter_boxes.h"
#include "sightline/culling/occlusion/internal/front_layer.h"
#include "sightline/culling/occlusion/internal/kernels.h"

namespace sightline::culling {
namespace {

struct EnteringBuffers {
  Judgement judged;
  PixelEntries entries;
  std::size_t memory_bytes() const { return core::bytes_of(judged); }
};

struct LeafBuffers {
  core::VisibleSet leaves;
  std::size_t memory_bytes() const { return core::bytes_of(leaves); }
};

struct FrontBuffers {
  SetParts parts;
  FrontLayers layers;
  std::vector<std::uint64_t> in_front, others;  // a bit per slot
  core::VisibleSet unoccluded;
  std::size_t memory_bytes() const { return core::bytes_of(parts, layers, in_front, others, unoccluded); }
};

/// Enters sixteen boxes that have waited in a queue.
void enter_queued(const DepthTest& depth, const SmallBoxes& boxes, std::span<const RayQueues::Place> places,
                  EnteringBuffers& buffers, FrontLayer& layer) {
  auto& [judged, entries] = buffers;
  const unsigned found = depth.unoccluded_boxes(boxes, &entries);
  for (const PixelEntries::Entry& e : std::span(entries.of).first(std::size_t(entries.count)))
    layer.enter(std::size_t(e.y) * std::size_t(depth.width()) + std::size_t(e.x), e.distance,
                places[std::size_t(e.box)].slot);
  for (std::size_t i = 0; i < places.size(); ++i) {
    if ((found >> i & 1u) == 0) judged.hide(places[i]);
    if ((entries.judged >> i & 1u) == 0) layer.not_judged.push_back(places[i].slot);
  }
}

/// Replaces `unoccluded` by the slots of `in` that are not hidden, and enters them.
void enter_all(const DepthTest& depth, const core::ItemBounds& bounds, const core::VisibleSet& in,
               core::VisibleSet& unoccluded, FrontLayer& layer) {
  using Found = DepthTest::Found;
  const core::Scratch<EnteringBuffers> scratch;
  Judgement& judged = scratch->judged;
  const auto test = [&](const SmallBoxes& boxes, std::span<const RayQueues::Place> places) {
    enter_queued(depth, boxes, places, *scratch, layer);
  };
  for_each_group(bounds, in, [&](const SlotGroup& group, unsigned used, bool) {
    BoxRectangles r;
    const unsigned maybe = depth.maybe_unoccluded(group.coordinates, r) & used;
    judged.add_group(maybe);
    for (unsigned bits = maybe; bits != 0; bits &= bits - 1) {
      const int i = std::countr_zero(bits);
      const RayQueues::Place place{judged.last_group(), i, group.slots[i]};
      Found found = Found::kNotJudged;
      if (bounds.vacant(place.slot)) {
        found = Found::kOccluded;
      } else if ((r.projects >> i & 1u) != 0) {
        const BoxCoordinates box = box_of(group.coordinates, i);
        const PixelRectangle pixels = depth.pixels(r, i);
        if (depth.waits(pixels)) {
          judged.queues.add(box, pixels, place, test);
          continue;
        }
        found = depth.enter(place.slot, box, pixels, r.nearest[i], layer);
      }
      if (found == Found::kOccluded) judged.hide(place);
      if (found == Found::kNotJudged) layer.not_judged.push_back(place.slot);
    }
  });
  judged.queues.finish(test);
  judged.list(in, unoccluded);
}

/// Calls visit(set) with `in` after filter_leaves(), or as it is without a hierarchy.
template <class Visit>
void with_open_leaves(const OcclusionTest& test, const Hierarchy* hierarchy, const core::VisibleSet& in,
                      SlotBits exempt, const Visit& visit) {
  if (!hierarchy) return visit(in);
  const core::Scratch<LeafBuffers> scratch;
  test.filter_leaves(*hierarchy, in, scratch->leaves, exempt);
  visit(scratch->leaves);
}

}  // namespace

OcclusionTest::OcclusionTest(const core::View& view, const core::dvec3& origin, int width, int height,
                             const DepthPyramid& pyramid, double error, float snap)
    : depth_(view, origin, width, height, pyramid, error, snap) {}

float OcclusionTest::distance(const core::Aabb& box) const {
  return depth_.distance(box);
}

bool OcclusionTest::occluded(const core::Aabb& box) const {
  return depth_.fits() && of_one_box(box, [&](const auto& boxes) { return depth_.occluded(boxes); });
}

void OcclusionTest::filter(const core::ItemBounds& bounds, const core::VisibleSet& in, core::VisibleSet& unoccluded,
                           SlotBits exempt, core::ThreadPool* threads, const Hierarchy* hierarchy) const {
  if (!depth_.fits()) {
    unoccluded = in;
    return;
  }
  const auto filter_part = [&](const core::VisibleSet& part, core::VisibleSet& kept) {
    with_open_leaves(*this, hierarchy, part, exempt,
                     [&](const core::VisibleSet& leaves) { filter_boxes(depth_, bounds, leaves, kept, exempt); });
  };
  filter_in_parts(in, unoccluded, threads, filter_part);
}

void OcclusionTest::filter_leaves(const Hierarchy& hierarchy, const core::VisibleSet& in, core::VisibleSet& unoccluded,
                                  SlotBits exempt) const {
  if (!depth_.fits()) {
    unoccluded = in;
    return;
  }
  culling::filter_leaves(hierarchy, in, unoccluded, exempt,
                         [&](const auto& boxes) { return depth_.unoccluded_nodes(boxes); });
}

void OcclusionTest::split_front(const core::ItemBounds& bounds, const Hierarchy* hierarchy, const core::VisibleSet& in,
                                core::VisibleSet& front, core::VisibleSet& behind, core::ThreadPool* threads) const {
  if (!depth_.fits()) {
    front = in;
    behind.clear();
    behind.generation = in.generation;
    return;
  }
  const core::Scratch<FrontBuffers> scratch;
  auto& [parts, layers, in_front, others, unoccluded] = *scratch;
  layers.begin(std::size_t(depth_.width()) * std::size_t(depth_.height()));
  parts.split(in);
  parts.for_each(threads, [&, &shared_layers = layers](core::VisibleSet& part, std::uint32_t) {
    FrontLayer& layer = shared_layers.take();
    with_open_leaves(*this, hierarchy, part, {},
                     [&](const core::VisibleSet& leaves) { enter_all(depth_, bounds, leaves, part, layer); });
    shared_layers.give_back(layer);
  });
  parts.join(unoccluded);
  in_front.assign(bit_words(bounds.size()), 0);
  others.assign(bit_words(bounds.size()), 0);
  layers.mark_front(in_front);
  set_bits(unoccluded, others);
  front.clear();
  behind.clear();
  front.generation = behind.generation = in.generation;
  for (std::size_t word = 0; word < others.size(); ++word) others[word] &= ~in_front[word];
  slots_of(in_front, front.single_slots);
  slots_of(others, behind.single_slots);
}

}  // namespace sightline::culling
