// Internal: the kernels of areas over any instruction set.
//
// Rows of an area are spans of columns, since the area is convex: sixteen spans at a time are cut out by its sides.
// Then each span is filled, sixteen pixels at a time, with the greater of what the image holds and the area's
// reciprocal depth.
#pragma once

#include "sightline/culling/occlusion/internal/kernels.h"
#include "sightline/culling/occlusion/internal/occluder_area.h"

namespace sightline::culling {

/// The spans of an area's rows.
template <class Simd>
class AreaRows {
 public:
  using Lanes = typename Simd::Lanes;

  explicit AreaRows(const OccluderArea& area) : area_(area) {}

  /// Calls visit(row, begin, end) for columns begin … end - 1 of rows that have some, until it returns true. Whether it
  /// has. Rows and columns count from the area's first ones.
  template <class Visit>
  bool any(const Visit& visit) const {
    for (int first = 0; first < area_.rows; first += kLanes) {
      const Lanes rows = Simd::add(Simd::ramp(), Simd::spread(float(first)));
      const Lanes none = Simd::spread(0.0f), all = Simd::spread(float(area_.columns));
      Lanes begin = none, end = all;
      for (int i = 0; i < area_.left_count; ++i) begin = Simd::most(begin, crossing(area_.left[i], rows));
      for (int i = 0; i < area_.right_count; ++i) end = Simd::least(end, crossing(area_.right[i], rows));
      float begins[kLanes], ends[kLanes];
      Simd::store(begins, Simd::least(begin, all));
      Simd::store(ends, Simd::most(end, none));
      const int count = area_.rows - first < kLanes ? area_.rows - first : kLanes;
      // The column right of a left side, and those up to a right one: both are whole parts, with column -1 at 0.
      for (int i = 0; i < count; ++i)
        if (int(begins[i]) < int(ends[i]) && visit(first + i, int(begins[i]), int(ends[i]))) return true;
    }
    return false;
  }

 private:
  static Lanes crossing(const OccluderArea::Side& side, const Lanes& rows) {
    return Simd::add(Simd::multiply(Simd::spread(side.slope), rows), Simd::spread(side.x));
  }

  const OccluderArea& area_;
};

/// Bits of those of kLanes columns from `first` on that lie in begin … end - 1.
static inline unsigned lanes_within(int first, int begin, int end) {
  unsigned bits = 0xffffu;
  if (first < begin) bits &= bits << (begin - first);
  if (end - first < kLanes) bits &= (1u << (end - first)) - 1u;
  return bits;
}

/// kPlanes: of the area, or 0 for any number.
template <class Simd, int kPlanes>
class AreaFiller {
 public:
  using Lanes = typename Simd::Lanes;

  AreaFiller(const OccluderArea& area, float* image, int stride)
      : area_(area), image_(image + area.row * std::ptrdiff_t(stride) + area.column), stride_(stride) {}

  void fill() const {
    AreaRows<Simd>(area_).any([&](int row, int begin, int end) {
      fill_row(row, begin, end);
      return false;
    });
  }

 private:
  void fill_row(int row, int begin, int end) const {
    const int planes = kPlanes > 0 ? kPlanes : area_.plane_count;
    Lanes constants[kPlanes > 0 ? kPlanes : OccluderArea::kMostPlanes];
    for (int k = 0; k < planes; ++k)
      constants[k] = Simd::spread(area_.planes[k].y * float(row) + area_.planes[k].constant);
    float* const pixels = image_ + row * std::ptrdiff_t(stride_);
    for (int first = begin / kLanes * kLanes; first < end; first += kLanes) {
      const Lanes columns = Simd::add(Simd::ramp(), Simd::spread(float(first)));
      Lanes reciprocal_depth = Simd::add(Simd::multiply(Simd::spread(area_.planes[0].x), columns), constants[0]);
      for (int k = 1; k < planes; ++k)
        reciprocal_depth = Simd::least(
            reciprocal_depth, Simd::add(Simd::multiply(Simd::spread(area_.planes[k].x), columns), constants[k]));
      reciprocal_depth = Simd::most(reciprocal_depth, Simd::spread(area_.least));
      Simd::raise(pixels + first, reciprocal_depth, lanes_within(first, begin, end));
    }
  }

  const OccluderArea& area_;
  float* image_;
  int stride_;
};

template <class Simd>
void fill_area(const OccluderArea& area, float* image, int stride) {
  switch (area.plane_count) {
    case 1:
      return AreaFiller<Simd, 1>(area, image, stride).fill();
    case 2:
      return AreaFiller<Simd, 2>(area, image, stride).fill();
    case 3:
      return AreaFiller<Simd, 3>(area, image, stride).fill();
    default:
      return AreaFiller<Simd, 0>(area, image, stride).fill();
  }
}

}  // namespace sightline::culling
