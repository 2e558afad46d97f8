#include "sightline/culling/occlusion/sample_test.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <limits>
#include <utility>

#include "sightline/culling/frustum/internal/set_parts.h"
#include "sightline/culling/occlusion/internal/filter_boxes.h"
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
  slots_of(bits, slots);
  return slots;
}

void slots_of(SlotBits bits, std::vector<core::Slot>& slots) {
  slots.clear();
  for (std::size_t word = 0; word < bits.size(); ++word)
    for (std::uint64_t left = bits[word]; left != 0; left &= left - 1)
      slots.push_back(core::Slot(64 * word) + core::Slot(std::countr_zero(left)));
}

/// Decides as DepthTest does, with nothing drawn yet: by rectangles, by the rays of three pixels, then by those of all.
class SampleTest::Boxes {
 public:
  explicit Boxes(const SampleTest& test) : test_(test), view_(test.view_) {
    static_assert(sizeof(test.samples_.offsets[0]) == sizeof(float[2]));
    view_.samples = reinterpret_cast<const float(*)[2]>(test.samples_.offsets.data());
    view_.sample_count = int(test.samples_.offsets.size());
    for (const auto& offset : test.samples_.offsets)
      for (std::size_t axis = 0; axis < 2; ++axis) {
        first_[axis] = std::min(first_[axis], offset[axis]);
        last_[axis] = std::max(last_[axis], offset[axis]);
      }
  }

  unsigned maybe_unoccluded(const float* const (&coordinates)[6], BoxRectangles& r) const {
    occlusion_kernels().rectangles(view_, coordinates, r);
    return r.covering;
  }
  unsigned undecided(const float* const (&coordinates)[6], const BoxRectangles& r, unsigned unoccluded) const {
    unsigned left = unoccluded & r.projects;
    for (const RayField& rays : test_.fields_) {
      if (left == 0) break;
      left &= ~occlusion_kernels().seen(view_, rays, coordinates, r, left, {});
    }
    return left;
  }
  /// With a sample in the rectangle, and perhaps a few others.
  PixelRectangle pixels(const BoxRectangles& r, int i) const {
    const PixelRectangle low = pixels_of(view_, r, i, last_[0], last_[1]);
    const PixelRectangle high = pixels_of(view_, r, i, first_[0], first_[1]);
    return {low.x0, low.y0, high.x1, high.y1};
  }
  bool waits(const PixelRectangle& pixels) const { return !test_.fields_.empty() && RayQueues::takes(pixels); }
  unsigned unoccluded_boxes(const SmallBoxes& boxes) const {
    unsigned found = 0;
    for (const RayField& rays : test_.fields_)
      found |= occlusion_kernels().unoccluded_boxes(rays, boxes, view_.snap, {}, {}, nullptr);
    return found;
  }
  bool hides(const BoxCoordinates& box, const PixelRectangle& pixels, float) const {
    if (waits(pixels)) return unoccluded_boxes(RayQueues::only(box, pixels)) == 0;
    BoxSpan span;
    const int width = pixels.x1 - pixels.x0 + 1, height = pixels.y1 - pixels.y0 + 1;
    return width <= kLanes && height <= kLanes && test_.rays_.span(box, span) && no_ray_meets(span, pixels);
  }

 private:
  bool no_ray_meets(const BoxSpan& span, const PixelRectangle& pixels) const {
    const TileShape shape(pixels.x1 - pixels.x0 + 1);
    alignas(64) float entries[kLanes];
    BlockTile tile{};
    tile.columns_log2 = shape.columns_log2;
    tile.step = 1.0f;
    tile.half_extent = view_.snap;
    tile.farthest = kNothingDrawn.data();
    tile.parallel = test_.rays_.parallel();
    for (const auto& [x, y] : test_.samples_.offsets) {
      tile.x = float(pixels.x0) + x;
      for (int at = pixels.y0; at <= pixels.y1; at += shape.rows()) {
        tile.y = float(at) + y;
        if ((occlusion_kernels().unoccluded_blocks(span, tile, entries) &
             shape.lanes(pixels.x1 - pixels.x0 + 1, pixels.y1 - at + 1)) != 0)
          return false;
      }
    }
    return true;
  }

  const SampleTest& test_;
  ScreenView view_;
  std::array<float, 2> first_ = test_.samples_.offsets[0], last_ = first_;  // least and greatest offsets
};

SampleTest::SampleTest(const core::View& view, const core::dvec3& origin, ImageSamples samples)
    : samples_(std::move(samples)),
      view_(make_screen_view(view, origin, samples_.width, samples_.height, samples_.snap)),
      rays_(view, origin, samples_.width, samples_.height) {
  assert(samples_.width > 0 && samples_.height > 0 && !samples_.offsets.empty());
  if (!rays_.usable()) return;
  for (const auto& [x, y] : samples_.offsets) fields_.push_back(rays_.field(x, y));
}

bool SampleTest::covers(const core::Aabb& box) const {
  const Boxes test(*this);
  return of_one_box(box, [&](const auto& boxes) { return unoccluded_of(test, boxes); });
}

void SampleTest::filter(const core::ItemBounds& bounds, const core::VisibleSet& in, core::VisibleSet& out,
                        SlotBits exempt, core::ThreadPool* threads) const {
  const Boxes test(*this);
  filter_in_parts(in, out, threads, [&](const core::VisibleSet& part, core::VisibleSet& kept) {
    filter_boxes(test, bounds, part, kept, exempt);
  });
}

}  // namespace sightline::culling
