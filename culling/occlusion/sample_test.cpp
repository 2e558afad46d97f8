#include "sightline/culling/occlusion/sample_test.h"

#include <bit>
#include <cassert>
#include <limits>
#include <utility>

#include "sightline/culling/occlusion/internal/filter_slots.h"
#include "sightline/culling/occlusion/internal/kernels.h"
#include "sightline/culling/occlusion/internal/tile_shape.h"

namespace sightline::culling {
namespace {

constexpr std::array<float, kLanes> kNothingDrawn = [] {
  std::array<float, kLanes> distances{};
  distances.fill(std::numeric_limits<float>::infinity());
  return distances;
}();

}  // namespace

void set_bits(const core::VisibleSet& set, std::vector<std::uint64_t>& bits) {
  set.for_each_slot([&](core::Slot s) { bits[s / 64] |= std::uint64_t(1) << s % 64; });
}

std::vector<core::Slot> slots_of(SlotBits bits) {
  std::vector<core::Slot> slots;
  for (std::size_t word = 0; word < bits.size(); ++word)
    for (std::uint64_t left = bits[word]; left != 0; left &= left - 1)
      slots.push_back(core::Slot(64 * word) + core::Slot(std::countr_zero(left)));
  return slots;
}

SampleTest::SampleTest(const core::View& view, const core::dvec3& origin, ImageSamples samples)
    : samples_(std::move(samples)),
      view_(make_screen_view(view, origin, samples_.width, samples_.height, samples_.snap)),
      rays_(view, origin, samples_.width, samples_.height) {
  assert(samples_.width > 0 && samples_.height > 0 && !samples_.offsets.empty());
}

ScreenView SampleTest::view() const {
  static_assert(sizeof(samples_.offsets[0]) == sizeof(float[2]));
  ScreenView view = view_;
  view.samples = reinterpret_cast<const float(*)[2]>(samples_.offsets.data());
  view.sample_count = int(samples_.offsets.size());
  return view;
}

/// Whether a ray through a sample in the rectangle of box i meets the box, as far as that can be said.
bool SampleTest::rays_meet(const BoxCoordinates& box, const BoxRectangles& rectangles, int i) const {
  BoxSpan span;
  if (rectangles.right[i] - rectangles.left[i] > float(kLanes - 1) ||
      rectangles.top[i] - rectangles.bottom[i] > float(kLanes - 1) || !rays_.span(box, span))
    return true;
  alignas(64) float entries[kLanes];
  BlockTile tile{};
  tile.step = 1.0f;
  tile.half_extent = view_.snap;
  tile.farthest = kNothingDrawn.data();
  tile.parallel = rays_.parallel();
  for (const auto& [x, y] : samples_.offsets) {
    const PixelRectangle pixels = pixels_of(view_, rectangles, i, x, y);
    const int width = pixels.x1 - pixels.x0 + 1;
    if (width <= 0) continue;
    const TileShape shape(width);
    tile.columns_log2 = shape.columns_log2;
    tile.rows = shape.rows();
    tile.x = float(pixels.x0) + x;
    for (int at = pixels.y0; at <= pixels.y1; at += shape.rows()) {
      tile.y = float(at) + y;
      if ((occlusion_kernels().unoccluded_blocks(span, tile, entries) & shape.lanes(width, pixels.y1 - at + 1)) != 0)
        return true;
    }
  }
  return false;
}

/// Bit i: box i of sixteen may cover a sample.
unsigned SampleTest::covering(const ScreenView& view, const float* const (&coordinates)[6]) const {
  BoxRectangles r;
  occlusion_kernels().rectangles(view, coordinates, r);
  unsigned found = r.covering;
  for (unsigned bits = r.covering & r.projects; bits != 0; bits &= bits - 1) {
    const int i = std::countr_zero(bits);
    if (!rays_meet(box_of(coordinates, i), r, i)) found &= ~(1u << i);
  }
  return found;
}

bool SampleTest::covers(const core::Aabb& box) const {
  return of_one_box(box, [&](const auto& boxes) { return covering(view(), boxes); });
}

void SampleTest::filter(const core::ItemBounds& bounds, const core::VisibleSet& in, core::VisibleSet& out,
                        SlotBits exempt) const {
  const ScreenView screen = view();
  filter_slots(bounds, in, out, exempt, [&](const auto& boxes) { return covering(screen, boxes); });
}

}  // namespace sightline::culling
