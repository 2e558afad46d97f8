// Internal: convex polygons of a fixed number of corners, eight at a time, for any instruction set. As occluders, they
// are rasterised. The plain form, for one polygon of any kind, is in occluder_raster.cpp. Both compute the same, bit by
// bit; what is computed, and why that is safe, is said there and in occluder_raster.h. In front of solids, they are
// tested against what the pixels hold. Then everything is rounded the other way: areas are larger, and nearer.
#pragma once

#include "sightline/culling/occlusion/internal/fill_area.h"
#include "sightline/culling/occlusion/internal/kernels.h"
#include "sightline/culling/occlusion/internal/occluder_image.h"
#include "sightline/culling/occlusion/internal/small_boxes.h"

// How vectors are passed differs between instruction sets. No function here is seen by more than one of them. Without
// an end, since g++ warns at the end of the file.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace sightline::culling {

/// Where polygons are in the picture: pixels that lie within for certain, and no nearer than there, or, if kOuter, all
/// that may lie within, and no farther.
template <class Simd, int kCorners, bool kOuter>
class PolygonAreas {
 public:
  using Polygons = PolygonBatch<kCorners>;

  PolygonAreas(const OccluderImage& image, const Polygons& polygons) : image_(image), polygons_(polygons) {
    place_corners();
    find_turn();
    find_pixels();
    limit_rows();
    find_sides();
    find_plane();
  }

  /// Whether rounding lets anything be said of polygon i.
  bool known(int i) const { return known_[i] != 0; }
  /// Of one that is known: whether it has pixels.
  bool covers(int i) const { return covers_[i] != 0; }
  /// Of one that covers pixels.
  OccluderArea area(int i) const {
    OccluderArea area;
    area.column = int(column_[i]), area.row = int(first_row_[i]);
    area.columns = int(columns_[i]), area.rows = int(rows_[i]);
    area.left_count = area.right_count = 0;
    for (int k = 0; k < kCorners; ++k) {
      if (side_counts_[k][i] == 0) continue;
      const OccluderArea::Side side{side_x_[k][i], side_slope_[k][i]};
      if (side_is_left_[k][i] != 0)
        area.left[area.left_count++] = side;
      else
        area.right[area.right_count++] = side;
    }
    area.least = least_[i];
    area.plane_count = 1;
    area.planes[0] = {plane_x_[i], plane_y_[i], plane_constant_[i]};
    return area;
  }

 private:
  static constexpr double kInwards = kOuter ? -1.0 : 1.0;
  typedef double Numbers __attribute__((vector_size(kPolygonsAtOnce * sizeof(double))));
  typedef int Places __attribute__((vector_size(kPolygonsAtOnce * sizeof(int))));
  typedef float Floats __attribute__((vector_size(kPolygonsAtOnce * sizeof(float))));
  using Mask = decltype(Numbers{} < Numbers{});  // all bits of an entry, or none

  static Numbers greater(const Numbers& a, const Numbers& b) { return a < b ? b : a; }
  static Numbers lesser(const Numbers& a, const Numbers& b) { return b < a ? b : a; }
  static Numbers magnitude(const Numbers& a) {
    return __builtin_bit_cast(Numbers, __builtin_bit_cast(Mask, a) & 0x7fffffffffffffff);
  }
  static Numbers spread(double a) { return Numbers{} + a; }
  static Numbers towards_zero(const Numbers& a) {
    return __builtin_convertvector(__builtin_convertvector(a, Places), Numbers);
  }
  /// As whole_between() of occluder_raster.cpp. None: first > last.
  static void whole_between(Numbers from, Numbers to, int size, Numbers& first, Numbers& last) {
    from = greater(from, spread(0.0)), to = lesser(to, spread(double(size - 1)));
    const Mask some = from <= to;
    const Numbers low = some ? from : spread(0.0), high = some ? to : spread(-1.0);
    const Numbers below = towards_zero(low);
    first = below + (below < low ? spread(1.0) : spread(0.0));
    last = towards_zero(high);
  }

  struct Form {
    const EyeForm& form;
    Numbers lost;
    Numbers operator()(const Numbers& x, const Numbers& y, const Numbers& z) const {
      return form.normal.x * x + form.normal.y * y + form.normal.z * z + form.at_eye;
    }
  };
  Form form_of(const EyeForm& form) const {
    const Numbers size = form.sizes.x * load(polygons_.reach[0]) + form.sizes.y * load(polygons_.reach[1]) +
                         form.sizes.z * load(polygons_.reach[2]) + (form.at_eye < 0.0 ? -form.at_eye : form.at_eye);
    return {form, raster::kLost * size + form.lost};
  }
  static Numbers load(const double (&a)[kPolygonsAtOnce]) {
    Numbers numbers;
    __builtin_memcpy(&numbers, a, sizeof(numbers));
    return numbers;
  }

  void place_corners() {
    const Form x_form = form_of(image_.x), y_form = form_of(image_.y), z_form = form_of(image_.z);
    const Numbers lost = greater(x_form.lost, y_form.lost);
    reach_ = spread(0.0);
    left_ = bottom_ = spread(raster::kLarge);
    right_ = top_ = spread(-raster::kLarge);
    farthest_ = spread(raster::kLarge);
    known_ = spread(0.0) == spread(0.0);
    for (int k = 0; k < kCorners; ++k) {
      const Numbers px = load(polygons_.x[k]), py = load(polygons_.y[k]), pz = load(polygons_.z[k]);
      Numbers x = x_form(px, py, pz), y = y_form(px, py, pz), reach;
      const Numbers z = z_form(px, py, pz);
      if (image_.perspective) {
        const Numbers inverse = 1.0 / z, off = z_form.lost * inverse;
        known_ &= (off >= 0.0) & (off < 0x1p-6) & (z < raster::kLarge);
        x *= inverse, y *= inverse;
        const Numbers place = greater(magnitude(x), magnitude(y));
        nearness_[k] = inverse * (1.0 - kInwards * 1.1 * off - kInwards * raster::kLost);
        reach = 1.1 * (lost * inverse + place * off) + raster::kPlaceLost * place;
      } else {
        nearness_[k] = -z - kInwards * z_form.lost - kInwards * raster::kLost * magnitude(z);
        reach = lost + raster::kPlaceLost * greater(magnitude(x), magnitude(y));
      }
      known_ &= (reach < raster::kMostReach) &
                (greater(greater(magnitude(x), magnitude(y)), magnitude(nearness_[k])) < raster::kLarge);
      x_[k] = x, y_[k] = y;
      reach_ = greater(reach_, reach);
      farthest_ = lesser(farthest_, nearness_[k]);
      left_ = lesser(left_, x), right_ = greater(right_, x);
      bottom_ = lesser(bottom_, y), top_ = greater(top_, y);
    }
  }

  void find_turn() {
    constexpr int kA = 0, kB = kCorners / 2, kC = kCorners / 4, kD = 3 * kCorners / 4;
    x1_ = x_[kB] - x_[kA], y1_ = y_[kB] - y_[kA], n1_ = nearness_[kB] - nearness_[kA];
    x2_ = x_[kD] - x_[kC], y2_ = y_[kD] - y_[kC], n2_ = nearness_[kD] - nearness_[kC];
    twice_area_ = x1_ * y2_ - x2_ * y1_;
    const Numbers first = magnitude(x1_) + magnitude(y1_), second = magnitude(x2_) + magnitude(y2_);
    const Numbers open = 8.0 * reach_ * (first + second) + raster::kLost * first * second;
    left_turn_ = twice_area_ > open;
    known_ &= left_turn_ | (twice_area_ < -open);
  }

  void find_pixels() {
    constexpr double kMostFloatLost = 0x1p-6;
    const Numbers grown = kOuter ? reach_ + image_.snap + kMostFloatLost : spread(0.0);
    Numbers first_row, last_row, first_column;
    whole_between(left_ - grown, right_ + grown, image_.width, first_column, last_column_);
    whole_between(bottom_ - grown, top_ + grown, image_.height, first_row, last_row);
    covers_ = (first_column <= last_column_) & (first_row <= last_row);
    column_ = towards_zero(first_column * (1.0 / kLanes)) * double(kLanes);
    columns_ = last_column_ - column_ + 1.0;
    const Numbers float_lost = 0x1p-21 * (greater(columns_, last_row - first_row) + 2.0);
    inset_ = reach_ + image_.snap + float_lost;
    first_row_ = first_row, last_row_ = last_row;
  }

  /// Of side k, in the order that turns left.
  struct Side {
    Numbers x, y, dx, dy;
  };
  Side side(int k) const {
    const int next = (k + 1) % kCorners;
    const Numbers dx = x_[next] - x_[k], dy = y_[next] - y_[k];
    return {left_turn_ ? x_[k] : x_[next], left_turn_ ? y_[k] : y_[next], left_turn_ ? dx : -dx, left_turn_ ? dy : -dy};
  }
  static Mask level(const Side& s) { return magnitude(s.dx) > raster::kSteepest * magnitude(s.dy); }

  void limit_rows() {
    Numbers low = first_row_, high = last_row_;
    for (int k = 0; k < kCorners; ++k) {
      const Side s = side(k);
      const Mask is_level = level(s);
      const Numbers slope = s.dy / s.dx, margin = kInwards * inset_ * (1.0 + magnitude(slope));
      const Numbers a = s.y + slope * (column_ - s.x), b = s.y + slope * (last_column_ - s.x);
      const Numbers lowest = (kOuter ? lesser(a, b) : greater(a, b)) + margin;
      const Numbers highest = (kOuter ? greater(a, b) : lesser(a, b)) - margin;
      low = (is_level & (s.dx > 0.0)) ? greater(low, lowest) : low;
      high = (is_level & ~(s.dx > 0.0)) ? lesser(high, highest) : high;
    }
    whole_between(low, high, image_.height, first_row_, last_row_);
    covers_ &= first_row_ <= last_row_;
    rows_ = last_row_ - first_row_ + 1.0;
  }

  void find_sides() {
    for (int k = 0; k < kCorners; ++k) {
      const Side s = side(k);
      const Numbers slope = s.dx / s.dy, margin = kInwards * inset_ * (1.0 + magnitude(slope));
      const Numbers x = s.x + (first_row_ - s.y) * slope - (column_ - 1.0);
      const Mask falls = s.dy < 0.0;
      side_x_[k] = __builtin_convertvector(falls ? x + margin : x - margin, Floats);
      side_slope_[k] = __builtin_convertvector(slope, Floats);
      side_is_left_[k] = falls;
      side_counts_[k] = ~(level(s) | (s.dy == 0.0));
    }
  }

  void find_plane() {
    const Numbers x = (n1_ * y2_ - n2_ * y1_) / twice_area_, y = (x1_ * n2_ - x2_ * n1_) / twice_area_;
    Numbers constant = spread(kInwards * raster::kLarge);
    for (int k = 0; k < kCorners; ++k) {
      const Numbers at_corner = nearness_[k] - x * (x_[k] - column_) - y * (y_[k] - first_row_);
      constant = kOuter ? greater(constant, at_corner) : lesser(constant, at_corner);
    }
    const Numbers off =
        reach_ + image_.snap +
        raster::kPlaceLost * (magnitude(left_) + magnitude(right_) + magnitude(bottom_) + magnitude(top_));
    constant -= kInwards * (magnitude(x) + magnitude(y)) * off;
    constant -= kInwards * (0x1p-21 * (magnitude(x) * columns_ + magnitude(y) * rows_ + magnitude(constant)) + 1e-36);
    const Numbers least = farthest_ - 0x1p-22 * magnitude(farthest_) - 1e-36;
    const Mask usable =
        (magnitude(x) < raster::kLarge) & (magnitude(y) < raster::kLarge) & (magnitude(constant) < raster::kLarge);
    if (kOuter) known_ &= usable;
    least_ = __builtin_convertvector(least, Floats);
    plane_x_ = __builtin_convertvector(usable ? x : spread(0.0), Floats);
    plane_y_ = __builtin_convertvector(usable ? y : spread(0.0), Floats);
    plane_constant_ = __builtin_convertvector(usable ? constant : least, Floats);
  }

  const OccluderImage& image_;
  const Polygons& polygons_;
  Numbers x_[kCorners], y_[kCorners], nearness_[kCorners];
  Numbers reach_, left_, right_, bottom_, top_, farthest_;
  Numbers x1_, y1_, n1_, x2_, y2_, n2_, twice_area_;  // as Diagonals of occluder_raster.cpp
  Numbers column_, last_column_, columns_, first_row_, last_row_, rows_, inset_;
  Mask known_, covers_, left_turn_;
  Mask side_counts_[kCorners], side_is_left_[kCorners];
  Floats side_x_[kCorners], side_slope_[kCorners], least_, plane_x_, plane_y_, plane_constant_;
};

/// See OcclusionKernels::cover_quads.
template <class Simd, int kCorners>
unsigned cover_polygons(const OccluderImage& image, const PolygonBatch<kCorners>& polygons, float* pixels) {
  const PolygonAreas<Simd, kCorners, false> areas(image, polygons);
  unsigned found = 0;
  for (int i = 0; i < polygons.count; ++i) {
    if (!areas.known(i) || !areas.covers(i)) continue;
    found |= 1u << i;
    fill_area<Simd>(areas.area(i), pixels, image.stride);
  }
  return found;
}

/// Whether some pixel of an area holds nothing nearer than the area.
template <class Simd>
bool seen_area(const OccluderArea& area, bool perspective, const PyramidBlocks& pyramid, const DistanceMargin& margin) {
  using Lanes = typename Simd::Lanes;
  const std::ptrdiff_t width = pyramid.widths[0];
  const float* const held = pyramid.farthest + area.row * width + area.column;
  const OccluderArea::Plane& plane = area.planes[0];
  return AreaRows<Simd>(area).any([&](int row, int begin, int end) {
    const Lanes constant = Simd::spread(plane.y * float(row) + plane.constant);
    for (int first = begin / kLanes * kLanes; first < end; first += kLanes) {
      const Lanes columns = Simd::add(Simd::ramp(), Simd::spread(float(first)));
      const Lanes nearness = Simd::add(Simd::multiply(Simd::spread(plane.x), columns), constant);
      constexpr float kLeast = 1e-30f;
      const Lanes distance = perspective ? Simd::divide(Simd::spread(1.0f), Simd::most(nearness, Simd::spread(kLeast)))
                                         : Simd::subtract(Simd::spread(0.0f), nearness);
      const unsigned hidden = Simd::less(Simd::load(held + row * width + first), in_front<Simd>(distance, margin));
      if ((~hidden & lanes_within(first, begin, end)) != 0) return true;
    }
    return false;
  });
}

/// OcclusionKernels::seen_quads: in front means that a pixel which may lie within the quad holds nothing nearer than
/// the quad there.
template <class Simd>
unsigned seen_quads(const OccluderImage& image, const PolygonBatch<4>& quads, const PyramidBlocks& pyramid,
                    const DistanceMargin& margin) {
  const PolygonAreas<Simd, 4, true> areas(image, quads);
  unsigned seen = 0;
  for (int i = 0; i < quads.count; ++i)
    if (!areas.known(i) || (areas.covers(i) && seen_area<Simd>(areas.area(i), image.perspective, pyramid, margin)))
      seen |= 1u << i;
  return seen;
}

}  // namespace sightline::culling
