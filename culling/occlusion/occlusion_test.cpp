#include "sightline/culling/occlusion/occlusion_test.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>

#include "sightline/culling/frustum/internal/set_parts.h"
#include "sightline/culling/occlusion/internal/filter_slots.h"
#include "sightline/culling/occlusion/internal/front_layer.h"
#include "sightline/culling/occlusion/internal/kernels.h"
#include "sightline/culling/occlusion/internal/ray_queues.h"
#include "sightline/culling/occlusion/internal/tile_shape.h"

namespace sightline::culling {
namespace {

constexpr float kCentre[1][2] = {{0.0f, 0.0f}};  // the one sample of a pixel
constexpr int kLevels = 4;     // of which the coarse one's blocks hold kLanes x kLanes of the fine one's
constexpr int kMostRows = 64;  // of blocks to look at; boxes that need more are open

/// Slots of a part, so that no thread waits long for another.
std::uint32_t part_size(std::size_t slots, int threads) {
  return std::uint32_t(std::clamp<std::size_t>(slots / std::size_t(4 * threads), 512, 8192));
}

void list_bits(std::size_t word, std::uint64_t bits, std::vector<core::Slot>& slots) {
  for (; bits != 0; bits &= bits - 1) slots.push_back(core::Slot(64 * word) + core::Slot(std::countr_zero(bits)));
}

}  // namespace

OcclusionTest::OcclusionTest(const core::View& view, const core::dvec3& origin, int width, int height,
                             const DepthPyramid& pyramid, double error, float snap)
    : view_(make_screen_view(view, origin, width, height, snap)),
      rays_(view, origin, width, height),
      ray_field_(rays_.field()),
      pyramid_(&pyramid),
      width_(width),
      height_(height),
      error_(float(error)) {
  view_.samples = kCentre;
  view_.sample_count = 1;
}

/// Whether these pixels hide whatever is no nearer than that.
bool OcclusionTest::hide_all(const PixelRectangle& pixels, float nearest) const {
  return pyramid_->all_nearer(pixels.x0, pixels.y0, pixels.x1, pixels.y1,
                              nearest - (kDistanceMargin * std::abs(nearest) + error_));
}

/// Whether all these pixels hide a box. `nearest`: its least distance.
bool OcclusionTest::hides(const BoxCoordinates& box, const PixelRectangle& pixels, float nearest) const {
  if (waits(pixels)) return open_boxes(RayQueues::only(box, pixels)) == 0;
  if (hide_all(pixels, nearest)) return true;
  BoxSpan span;
  if (!rays_.span(box, span)) return false;
  const unsigned size = unsigned(std::max(pixels.x1 - pixels.x0, pixels.y1 - pixels.y0));
  int level = 0;
  while (size >> level >= unsigned(kLanes) - 1) level += kLevels;
  int rows = 0;
  return all_hidden(span, pixels, std::min(level, pyramid_->level_count() - 1), rows);
}

/// Whether a box of these pixels is tested with others.
bool OcclusionTest::waits(const PixelRectangle& pixels) const {
  return rays_.usable() && RayQueues::takes(pixels);
}

/// See OcclusionKernels::open_boxes.
unsigned OcclusionTest::open_boxes(const SmallBoxes& boxes, PixelEntries* entries) const {
  return occlusion_kernels().open_boxes(ray_field_, boxes, view_.snap, pyramid_->blocks(), {kDistanceMargin, error_},
                                        entries);
}

/// For looks at blocks of a level.
BlockTile OcclusionTest::tile_of(const TileShape& shape, int level) const {
  const float step = float(1 << level);
  BlockTile tile{};
  tile.columns_log2 = shape.columns_log2;
  tile.step = step;
  tile.reach = 0.5f * (step - 1.0f) + view_.snap;
  tile.pitch = pyramid_->row(level, 1) - pyramid_->row(level, 0);
  tile.margin = {kDistanceMargin, error_};
  tile.parallel = rays_.parallel();
  return tile;
}

/// To the block x, y, the first of those to look at, which go up to the row `last`.
void OcclusionTest::move(BlockTile& tile, int level, int x, int y, int last) const {
  tile.x = (float(x) + 0.5f) * tile.step - 0.5f;
  tile.y = (float(y) + 0.5f) * tile.step - 0.5f;
  tile.farthest = pyramid_->row(level, y) + x;
  tile.rows = last - y + 1;
}

/// Whether no ray of these pixels meets the box in front of what the pixel holds. Looks at blocks of a level, and into
/// those that do not answer for all of their pixels.
bool OcclusionTest::all_hidden(const BoxSpan& box, const PixelRectangle& pixels, int level, int& rows) const {
  const PixelRectangle blocks{pixels.x0 >> level, pixels.y0 >> level, pixels.x1 >> level, pixels.y1 >> level};
  const TileShape shape(blocks.x1 - blocks.x0 + 1);
  BlockTile tile = tile_of(shape, level);
  alignas(64) float entries[kLanes];
  for (int y = blocks.y0; y <= blocks.y1; y += shape.rows()) {
    rows += std::min(shape.rows(), blocks.y1 - y + 1);
    if (rows > kMostRows) return false;
    move(tile, level, blocks.x0, y, blocks.y1);
    unsigned open =
        occlusion_kernels().open_blocks(box, tile, entries) & shape.lanes(blocks.x1 - blocks.x0 + 1, blocks.y1 - y + 1);
    if (open != 0 && level == 0) return false;
    for (; open != 0; open &= open - 1) {
      const int lane = std::countr_zero(open), at_x = blocks.x0 + shape.x(lane), at_y = y + shape.y(lane);
      const PixelRectangle inside{std::max(pixels.x0, at_x << level), std::max(pixels.y0, at_y << level),
                                  std::min(pixels.x1, ((at_x + 1) << level) - 1),
                                  std::min(pixels.y1, ((at_y + 1) << level) - 1)};
      if (!all_hidden(box, inside, std::max(0, level - kLevels), rows)) return false;
    }
  }
  return true;
}

float OcclusionTest::distance(const core::Aabb& box) const {
  const LinearForm& t = view_.t;
  return t.x * (t.x > 0.0f ? box.min.x : box.max.x) + t.y * (t.y > 0.0f ? box.min.y : box.max.y) +
         t.z * (t.z > 0.0f ? box.min.z : box.max.z) + t.d;
}

bool OcclusionTest::hidden(const core::Aabb& box) const {
  return fits() && of_one_box(box, [&](const auto& boxes) { return hidden_of(boxes); });
}

/// Of sixteen boxes those that may cover a pixel centre, and that one look at the pyramid does not hide.
unsigned OcclusionTest::maybe_open(const float* const (&coordinates)[6], BoxRectangles& r) const {
  occlusion_kernels().rectangles(view_, coordinates, r);
  const unsigned judged = r.covering & r.projects;
  if (judged == 0) return r.covering;
  return r.covering & ~(judged & occlusion_kernels().behind(view_, r, pyramid_->blocks(), {kDistanceMargin, error_}));
}

/// Of sixteen boxes those whose rays are worth testing: not hidden by all their pixels alike, nor seen at one of three.
unsigned OcclusionTest::undecided(const float* const (&coordinates)[6], const BoxRectangles& r, unsigned open) const {
  unsigned judged = open & r.projects;
  if (judged != 0 && rays_.usable())
    judged &= ~occlusion_kernels().seen(view_, ray_field_, coordinates, r, judged, pyramid_->blocks());
  return judged;
}

/// As hidden_of(), without the rays of single pixels: nodes are large.
unsigned OcclusionTest::open_nodes(const float* const (&coordinates)[6]) const {
  BoxRectangles r;
  unsigned open = maybe_open(coordinates, r);
  for (unsigned bits = undecided(coordinates, r, open); bits != 0; bits &= bits - 1) {
    const int i = std::countr_zero(bits);
    if (hide_all(pixels_of(view_, r, i), r.nearest[i])) open &= ~(1u << i);
  }
  return open;
}

/// Bit i: box i of sixteen is hidden, or covers no pixel centre.
unsigned OcclusionTest::hidden_of(const float* const (&coordinates)[6]) const {
  BoxRectangles r;
  const unsigned open = maybe_open(coordinates, r);
  unsigned found = ~open;
  for (unsigned bits = undecided(coordinates, r, open); bits != 0; bits &= bits - 1) {
    const int i = std::countr_zero(bits);
    if (hides(box_of(coordinates, i), pixels_of(view_, r, i), r.nearest[i])) found |= 1u << i;
  }
  return found;
}

/// What is known of the boxes of a set.
struct OcclusionTest::Judgement {
  void add_group(unsigned open) { of_groups.push_back(std::uint16_t(open)); }
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

  std::vector<std::uint16_t> of_groups;  // bits of open boxes
  RayQueues queues;                      // of those whose rays are still to be tested
  SlotCollector collector;
};

void OcclusionTest::filter(const core::ItemBounds& bounds, const core::VisibleSet& in, core::VisibleSet& open,
                           SlotBits exempt, CullThreads* threads, const Hierarchy* hierarchy) const {
  if (!fits()) {
    open = in;
    return;
  }
  const auto filter_part = [&](const core::VisibleSet& part, core::VisibleSet& kept) {
    filter_boxes(bounds, open_leaves(hierarchy, part, exempt), kept, exempt);
  };
  if (!threads) return filter_part(in, open);
  thread_local SetParts parts;
  parts.split(in, part_size(in.count(), threads->count()));
  parts.for_each(threads, [&](core::VisibleSet& part, std::uint32_t) { filter_part(part, part); });
  parts.join(open);
}

/// `in` after filter_leaves(), or as it is without a hierarchy; until this thread's next call.
const core::VisibleSet& OcclusionTest::open_leaves(const Hierarchy* hierarchy, const core::VisibleSet& in,
                                                   SlotBits exempt) const {
  if (!hierarchy) return in;
  thread_local core::VisibleSet leaves;
  filter_leaves(*hierarchy, in, leaves, exempt);
  return leaves;
}

void OcclusionTest::filter_boxes(const core::ItemBounds& bounds, const core::VisibleSet& in, core::VisibleSet& open,
                                 SlotBits exempt) const {
  thread_local Judgement judged;
  const auto test = [&](const SmallBoxes& boxes, std::span<const RayQueues::Place> places) {
    const unsigned found = open_boxes(boxes);
    for (std::size_t i = 0; i < places.size(); ++i)
      if ((found >> i & 1u) == 0) judged.hide(places[i]);
  };
  for_each_group(bounds, in, [&](const SlotGroup& group, unsigned used, bool) {
    BoxRectangles r;
    const unsigned spared = bits_in(exempt, group);
    const unsigned maybe = maybe_open(group.coordinates, r) & used;
    judged.add_group(maybe | spared);
    for (unsigned bits = undecided(group.coordinates, r, maybe) & ~spared; bits != 0; bits &= bits - 1) {
      const int i = std::countr_zero(bits);
      const RayQueues::Place place{judged.last_group(), i, group.slots[i]};
      const BoxCoordinates box = box_of(group.coordinates, i);
      const PixelRectangle pixels = pixels_of(view_, r, i);
      if (waits(pixels))
        judged.queues.add(box, pixels, place, test);
      else if (hides(box, pixels, r.nearest[i]))
        judged.hide(place);
    }
  });
  judged.queues.finish(test);
  judged.list(in, open);
}

void OcclusionTest::filter_leaves(const Hierarchy& hierarchy, const core::VisibleSet& in, core::VisibleSet& open,
                                  SlotBits exempt) const {
  if (!fits()) {
    open = in;
    return;
  }
  culling::filter_leaves(hierarchy, in, open, exempt, [&](const auto& boxes) { return open_nodes(boxes); });
}

OcclusionTest::Found OcclusionTest::enter(core::Slot slot, const BoxCoordinates& box, const PixelRectangle& pixels,
                                          float nearest, FrontLayer& layer) const {
  if (hide_all(pixels, nearest)) return Found::kHidden;
  BoxSpan span;
  const int columns = (pixels.x1 - pixels.x0) / kLanes + 1;
  if (columns * (pixels.y1 - pixels.y0 + 1) > kMostRows || !rays_.span(box, span))
    return hides(box, pixels, nearest) ? Found::kHidden : Found::kNotJudged;
  const TileShape shape(pixels.x1 - pixels.x0 + 1);
  BlockTile tile = tile_of(shape, 0);
  alignas(64) float entries[kLanes];
  Found found = Found::kHidden;
  for (int y = pixels.y0; y <= pixels.y1; y += shape.rows())
    for (int x = pixels.x0; x <= pixels.x1; x += shape.columns()) {
      move(tile, 0, x, y, pixels.y1);
      const unsigned lanes = shape.lanes(pixels.x1 - x + 1, pixels.y1 - y + 1);
      for (unsigned open = occlusion_kernels().open_blocks(span, tile, entries) & lanes; open != 0; open &= open - 1) {
        const int lane = std::countr_zero(open);
        const std::size_t row = std::size_t(y + shape.y(lane)) * std::size_t(pyramid_->width());
        layer.enter(row + std::size_t(x + shape.x(lane)), entries[lane], slot);
        found = Found::kEntered;
      }
    }
  return found;
}

/// Replaces `open` by the slots of `in` that are not hidden, and enters them.
void OcclusionTest::enter_all(const core::ItemBounds& bounds, const core::VisibleSet& in, core::VisibleSet& open,
                              FrontLayer& layer) const {
  thread_local Judgement judged;
  thread_local PixelEntries entries;
  const auto test = [&](const SmallBoxes& boxes, std::span<const RayQueues::Place> places) {
    const unsigned found = open_boxes(boxes, &entries);
    for (const PixelEntries::Entry& e : std::span(entries.of).first(std::size_t(entries.count)))
      layer.enter(std::size_t(e.y) * std::size_t(pyramid_->width()) + std::size_t(e.x), e.distance,
                  places[std::size_t(e.box)].slot);
    for (std::size_t i = 0; i < places.size(); ++i) {
      if ((found >> i & 1u) == 0) judged.hide(places[i]);
      if ((entries.judged >> i & 1u) == 0) layer.not_judged.push_back(places[i].slot);
    }
  };
  for_each_group(bounds, in, [&](const SlotGroup& group, unsigned used, bool) {
    BoxRectangles r;
    const unsigned maybe = maybe_open(group.coordinates, r) & used;
    judged.add_group(maybe);
    for (unsigned bits = maybe; bits != 0; bits &= bits - 1) {
      const int i = std::countr_zero(bits);
      const RayQueues::Place place{judged.last_group(), i, group.slots[i]};
      Found found = Found::kNotJudged;
      if (bounds.vacant(place.slot)) {
        found = Found::kHidden;
      } else if ((r.projects >> i & 1u) != 0) {
        const BoxCoordinates box = box_of(group.coordinates, i);
        const PixelRectangle pixels = pixels_of(view_, r, i);
        if (waits(pixels)) {
          judged.queues.add(box, pixels, place, test);
          continue;
        }
        found = enter(place.slot, box, pixels, r.nearest[i], layer);
      }
      if (found == Found::kHidden) judged.hide(place);
      if (found == Found::kNotJudged) layer.not_judged.push_back(place.slot);
    }
  });
  judged.queues.finish(test);
  judged.list(in, open);
}

void OcclusionTest::split_front(const core::ItemBounds& bounds, const Hierarchy* hierarchy, const core::VisibleSet& in,
                                core::VisibleSet& front, core::VisibleSet& behind, CullThreads* threads) const {
  if (!fits()) {
    front = in;
    behind.clear();
    behind.generation = in.generation;
    return;
  }
  thread_local SetParts parts;
  thread_local FrontLayers layers;
  thread_local std::vector<std::uint64_t> in_front, others;
  thread_local core::VisibleSet open;
  layers.begin(std::size_t(pyramid_->width()) * std::size_t(pyramid_->height()));
  parts.split(in);
  parts.for_each(threads, [&, &own_layers = layers](core::VisibleSet& part, std::uint32_t) {
    FrontLayer& layer = own_layers.take();
    enter_all(bounds, open_leaves(hierarchy, part, {}), part, layer);
    own_layers.give_back(layer);
  });
  parts.join(open);
  in_front.assign(bit_words(bounds.size()), 0);
  others.assign(bit_words(bounds.size()), 0);
  layers.mark_front(in_front);
  set_bits(open, others);
  front.clear();
  behind.clear();
  front.generation = behind.generation = in.generation;
  for (std::size_t word = 0; word < in_front.size(); ++word) {
    list_bits(word, in_front[word], front.items);
    list_bits(word, others[word] & ~in_front[word], behind.items);
  }
}

}  // namespace sightline::culling
