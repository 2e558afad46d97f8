// Internal: the kernels of sample, contribution and occlusion tests over any instruction set. `Simd` holds sixteen
// boxes or pixels. It lies in the anonymous namespace of its file, so that every instance is local to the file.
#pragma once

#include "sightline/culling/occlusion/internal/cover_polygons.h"
#include "sightline/culling/occlusion/internal/depth_rows.h"
#include "sightline/culling/occlusion/internal/fill_area.h"
#include "sightline/culling/occlusion/internal/kernels.h"
#include "sightline/culling/occlusion/internal/screen_boxes.h"
#include "sightline/culling/occlusion/internal/small_boxes.h"
#include "sightline/culling/occlusion/internal/triangle_samples.h"

namespace sightline::culling {

/// Places of lanes in a tile, from its first block's, by the binary logarithm of its columns.
struct TilePlaces {
  alignas(64) float x[5][kLanes], y[5][kLanes];
};
inline constexpr TilePlaces kTilePlaces = [] {
  TilePlaces places{};
  for (int columns_log2 = 0; columns_log2 < 5; ++columns_log2)
    for (int lane = 0; lane < kLanes; ++lane) {
      places.x[columns_log2][lane] = float(lane & ((1 << columns_log2) - 1));
      places.y[columns_log2][lane] = float(lane >> columns_log2);
    }
  return places;
}();

/// The keys of a face in the sixteen blocks of a tile, at the place of a block where they are greatest (sign 1) or
/// least.
template <class Simd>
typename Simd::Lanes keys_of_face(const ImageFunction& f, float half_extent, const typename Simd::Lanes& x,
                                  const typename Simd::Lanes& y, float sign) {
  const float slope = (f.x < 0.0f ? -f.x : f.x) + (f.y < 0.0f ? -f.y : f.y);
  const auto in_row = Simd::add(Simd::spread(f.constant), Simd::multiply(Simd::spread(f.y), y));
  return Simd::add(Simd::add(in_row, Simd::spread(sign * half_extent * slope)), Simd::multiply(Simd::spread(f.x), x));
}

/// What the blocks of a tile hold.
template <class Simd>
typename Simd::Lanes held_by(const BlockTile& tile) {
  if (tile.columns_log2 == 4) return Simd::load(tile.farthest);
  const auto places = [&](const float(&of)[kLanes]) { return Simd::place_below(Simd::load(of)); };
  const auto x = places(kTilePlaces.x[tile.columns_log2]);
  const auto y = Simd::smaller(places(kTilePlaces.y[tile.columns_log2]), Simd::spread_place(tile.rows - 1));
  return Simd::look_up(tile.farthest, Simd::plus(x, Simd::times(y, Simd::spread_place(int(tile.pitch)))));
}

template <class Simd>
unsigned unoccluded_blocks(const BoxSpan& box, const BlockTile& tile, float* entries) {
  using Lanes = typename Simd::Lanes;
  const auto places = [&](float first, const float(&of)[kLanes]) {
    return Simd::add(Simd::spread(first), Simd::multiply(Simd::spread(tile.step), Simd::load(of)));
  };
  const Lanes x = places(tile.x, kTilePlaces.x[tile.columns_log2]);
  const Lanes y = places(tile.y, kTilePlaces.y[tile.columns_log2]);
  const auto keys = [&](const ImageFunction& f, float sign) {
    return keys_of_face<Simd>(f, tile.half_extent, x, y, sign);
  };
  Lanes entry = keys(box.near[0], 1.0f);
  for (int i = 1; i < box.near_count; ++i) entry = Simd::least(entry, keys(box.near[i], 1.0f));
  Lanes exit = keys(box.far[0], -1.0f);
  for (int i = 1; i < box.far_count; ++i) exit = Simd::most(exit, keys(box.far[i], -1.0f));
  const Lanes distance =
      tile.parallel ? Simd::subtract(Simd::spread(0.0f), entry) : Simd::divide(Simd::spread(1.0f), entry);
  const Lanes least = in_front<Simd>(distance, tile.margin);
  Simd::store(entries, distance);
  return Simd::at_most(exit, entry) & ~Simd::less(held_by<Simd>(tile), least) & 0xffffu;
}

/// OcclusionKernels::behind: one look at the finest level at which 2 x 2 blocks contain a rectangle's pixels: 2^level
/// exceeds the difference of their places. All lanes look within the pyramid, whatever their rectangles hold.
template <class Simd>
unsigned behind(const ScreenView& view, const BoxRectangles& boxes, const PyramidBlocks& pyramid,
                const DistanceMargin& margin) {
  using Lanes = typename Simd::Lanes;
  using Places = typename Simd::Places;
  const Lanes zero = Simd::spread(0.0f);
  const auto within = [&](const float* a, float last) {
    return Simd::least(Simd::spread(last), Simd::most(zero, Simd::load(a)));
  };
  Places x0 = Simd::place_above(within(boxes.left, view.last_x)),
         x1 = Simd::place_below(within(boxes.right, view.last_x));
  Places y0 = Simd::place_above(within(boxes.bottom, view.last_y)),
         y1 = Simd::place_below(within(boxes.top, view.last_y));
  const Places wanted = Simd::bit_width(Simd::larger(Simd::minus(x1, x0), Simd::minus(y1, y0)));
  const Places level = Simd::smaller(wanted, Simd::spread_place(pyramid.level_count - 1));
  static_assert(PyramidBlocks::kMostLevels == kLanes);
  const Places width = Simd::pick(pyramid.widths, level), first = Simd::pick(pyramid.firsts, level);
  x0 = Simd::shifted(x0, level), x1 = Simd::shifted(x1, level);
  const Places row0 = Simd::plus(first, Simd::times(Simd::shifted(y0, level), width));
  const Places row1 = Simd::plus(first, Simd::times(Simd::shifted(y1, level), width));
  const auto farthest = [&](const Places& row) {
    return Simd::most(Simd::look_up(pyramid.farthest, Simd::plus(row, x0)),
                      Simd::look_up(pyramid.farthest, Simd::plus(row, x1)));
  };
  const Lanes held = Simd::most(farthest(row0), farthest(row1));
  return Simd::less(held, in_front<Simd>(Simd::load(boxes.nearest), margin)) & Simd::equal(wanted, level);
}

/// Bits of those of sixteen boxes that the rays of these pixels, one for each box, meet in front of what the pixels
/// hold.
template <class Simd>
unsigned seen_at(const typename Simd::Lanes& x, const typename Simd::Lanes& y, const RayField& rays,
                 const float* const (&coordinates)[6], const PyramidBlocks& pyramid) {
  using Lanes = typename Simd::Lanes;
  Lanes enter = Simd::spread(0.0f), leave = enter;
  for (int axis = 0; axis < 3; ++axis) {
    const Lanes of_pixel =
        Simd::add(Simd::spread(rays.constant[axis]), Simd::add(Simd::multiply(Simd::spread(rays.per_x[axis]), x),
                                                               Simd::multiply(Simd::spread(rays.per_y[axis]), y)));
    const Lanes along = rays.parallel ? Simd::spread(rays.along[axis]) : of_pixel;
    const Lanes from = rays.parallel ? of_pixel : Simd::spread(rays.from[axis]);
    const Lanes per_metre = Simd::divide(Simd::spread(1.0f), along);
    const Lanes a = Simd::multiply(Simd::subtract(Simd::load(coordinates[axis]), from), per_metre);
    const Lanes b = Simd::multiply(Simd::subtract(Simd::load(coordinates[axis + 3]), from), per_metre);
    const Lanes first = Simd::least(a, b), last = Simd::most(a, b);
    enter = axis == 0 ? first : Simd::most(enter, first);
    leave = axis == 0 ? last : Simd::least(leave, last);
  }
  const unsigned met = Simd::at_most(enter, leave);
  if (!pyramid.farthest) return met;
  const typename Simd::Places pixel =
      Simd::plus(Simd::place_below(x), Simd::times(Simd::place_below(y), Simd::spread_place(pyramid.widths[0])));
  return met & Simd::less(enter, Simd::look_up(pyramid.farthest, pixel));
}

/// OcclusionKernels::seen: most boxes that are not hidden are known so without a look at all of their pixels. Looks at
/// three pixels along the rectangle's longer side, at the middle one alone where that answers for all boxes in `asked`.
template <class Simd>
unsigned seen(const ScreenView& view, const RayField& rays, const float* const (&coordinates)[6],
              const BoxRectangles& boxes, unsigned asked, const PyramidBlocks& pyramid) {
  using Lanes = typename Simd::Lanes;
  const Lanes zero = Simd::spread(0.0f), half = Simd::spread(0.5f);
  const Lanes left = Simd::load(boxes.left), right = Simd::load(boxes.right);
  const Lanes bottom = Simd::load(boxes.bottom), top = Simd::load(boxes.top);
  const Lanes width = Simd::subtract(right, left), height = Simd::subtract(top, bottom);
  const unsigned wide = Simd::less(height, width);
  const auto pixel = [&](const Lanes& low, const Lanes& size, const Lanes& share, float last) {
    const Lanes at = Simd::add(Simd::add(low, Simd::multiply(share, size)), half);
    return Simd::whole(Simd::least(Simd::spread(last), Simd::most(zero, at)));
  };
  unsigned found = 0;
  for (const float share : {0.5f, 0.25f, 0.75f}) {
    const Lanes along = Simd::spread(share);
    const Lanes x = pixel(left, width, Simd::choose(wide, along, half), view.last_x);
    const Lanes y = pixel(bottom, height, Simd::choose(wide, half, along), view.last_y);
    found |= seen_at<Simd>(x, y, rays, coordinates, pyramid);
    if ((asked & ~found) == 0) break;
  }
  return found;
}

template <class Simd>
constexpr OcclusionKernels make_occlusion_kernels() {
  OcclusionKernels k{};
  k.rectangles = [](const ScreenView& view, const float* const(&c)[6], BoxRectangles& out) {
    ScreenBoxes<Simd>(view, c).store(view, out);
  };
  k.areas = ScreenBoxes<Simd>::store_areas;
  k.splats = ScreenBoxes<Simd>::store_splats;
  k.behind = behind<Simd>;
  k.seen = seen<Simd>;
  k.unoccluded_blocks = unoccluded_blocks<Simd>;
  k.unoccluded_boxes = unoccluded_boxes<Simd>;
  k.all_less = [](const float* first, std::ptrdiff_t pitch, int width, int height, float limit) {
    const unsigned looked_at = (1u << width) - 1u;
    const auto most = Simd::spread(limit);
    for (const float* row = first; height > 0; --height, row += pitch)
      if ((~Simd::less(Simd::load(row), most) & looked_at) != 0) return false;
    return true;
  };
  k.fill_area = fill_area<Simd>;
  k.cover_quads = cover_polygons<Simd, 4>;
  k.cover_octagons = cover_polygons<Simd, 8>;
  k.seen_quads = seen_quads<Simd>;
  k.shown_triangles = shown_triangles<Simd>;
  k.distances = distances<Simd>;
  k.coarser_row = coarser_row<Simd>;
  return k;
}

}  // namespace sightline::culling
