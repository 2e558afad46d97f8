// Internal: convex polygons of a fixed number of corners, eight at a time, for any instruction set. As occluders, they
// are rasterised; what is computed (polygon_area.h), and why that is safe, is said in occluder_raster.h. In front of
// solids, they are tested against what the pixels hold. Then everything is rounded the other way: areas are larger, and
// nearer.
#pragma once

#include "sightline/culling/occlusion/detail/occluder_image.h"
#include "sightline/culling/occlusion/internal/fill_area.h"
#include "sightline/culling/occlusion/internal/kernels.h"
#include "sightline/culling/occlusion/internal/polygon_area.h"
#include "sightline/culling/occlusion/internal/small_boxes.h"

// How vectors are passed differs between instruction sets. No function here is seen by more than one of them. Without
// an end, since g++ warns at the end of the file.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace sightline::culling {

/// The areas of polygons: pixels that lie within for certain, and no nearer than there, or, if kOuter, all that may lie
/// within, and no farther.
template <class Simd, int kCorners, bool kOuter>
class PolygonAreas {
 public:
  using Polygons = PolygonBatch<kCorners>;

  PolygonAreas(const OccluderImage& image, const Polygons& polygons) : image_(image), polygons_(polygons) {
    place_corners();
    find_winding();
    covers_ = area_.find_pixels(image.width, image.height, image.snap);
    for (int k = 0; k < kCorners; ++k) area_.limit_rows(side(k));
    covers_ &= area_.take_rows(image.height);
    find_lines();
    find_plane();
  }

  /// Whether rounding lets anything be said of polygon i.
  bool known(int i) const { return known_[i] != 0; }
  /// Whether a polygon that is known has pixels.
  bool covers(int i) const { return covers_[i] != 0; }
  /// The area of a polygon that covers pixels.
  OccluderArea area(int i) const {
    OccluderArea area;
    area.column = int(area_.column()[i]), area.row = int(area_.first_row()[i]);
    area.columns = int(area_.columns()[i]), area.rows = int(area_.rows()[i]);
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
  typedef double Numbers __attribute__((vector_size(kPolygonsAtOnce * sizeof(double))));
  typedef float Floats __attribute__((vector_size(kPolygonsAtOnce * sizeof(float))));
  using Area = raster::PolygonArea<Simd, Numbers, kOuter>;
  using Mask = typename Area::Mask;
  static constexpr double kInwards = Area::kInwards;

  struct Form {
    const EyeForm& form;
    Numbers lost;
    Numbers operator()(const Numbers& x, const Numbers& y, const Numbers& z) const {
      return form.normal.x * x + form.normal.y * y + form.normal.z * z + form.at_eye;
    }
  };
  Form form_of(const EyeForm& form) const {
    const Numbers size = form.sizes.x * load(polygons_.magnitudes[0]) + form.sizes.y * load(polygons_.magnitudes[1]) +
                         form.sizes.z * load(polygons_.magnitudes[2]) +
                         (form.at_eye < 0.0 ? -form.at_eye : form.at_eye);
    return {form, raster::kLost * size + form.lost};
  }
  static Numbers load(const double (&a)[kPolygonsAtOnce]) {
    Numbers numbers;
    __builtin_memcpy(&numbers, a, sizeof(numbers));
    return numbers;
  }

  void place_corners() {
    const Form x_form = form_of(image_.x), y_form = form_of(image_.y), z_form = form_of(image_.z);
    const Numbers lost = Area::greater(x_form.lost, y_form.lost);
    known_ = Area::spread(0.0) == Area::spread(0.0);
    for (int k = 0; k < kCorners; ++k) {
      const Numbers px = load(polygons_.x[k]), py = load(polygons_.y[k]), pz = load(polygons_.z[k]);
      Numbers x = x_form(px, py, pz), y = y_form(px, py, pz), reciprocal_depth, error;
      const Numbers z = z_form(px, py, pz);
      if (image_.perspective) {
        const Numbers inverse = 1.0 / z, off = z_form.lost * inverse;
        known_ &= (off >= 0.0) & (off < 0x1p-6) & (z < raster::kLarge);
        x *= inverse, y *= inverse;
        const Numbers place = Area::greater(Area::magnitude(x), Area::magnitude(y));
        reciprocal_depth = inverse * (1.0 - kInwards * 1.1 * off - kInwards * raster::kLost);
        error = 1.1 * (lost * inverse + place * off) + raster::kPlaceLost * place;
      } else {
        reciprocal_depth = -z - kInwards * z_form.lost - kInwards * raster::kLost * Area::magnitude(z);
        error = lost + raster::kPlaceLost * Area::greater(Area::magnitude(x), Area::magnitude(y));
      }
      const Numbers largest =
          Area::greater(Area::greater(Area::magnitude(x), Area::magnitude(y)), Area::magnitude(reciprocal_depth));
      known_ &= (error < raster::kMostError) & (largest < raster::kLarge);
      corners_[k] = {x, y, reciprocal_depth};
      area_.add(x, y, reciprocal_depth, error);
    }
  }

  void find_winding() {
    const auto diagonals = Area::diagonals(kCorners, [&](int k) { return corners_[k]; });
    const Numbers open = diagonals.open(area_.error());
    counter_clockwise_ = diagonals.area > open;
    known_ &= counter_clockwise_ | (diagonals.area < -open);
  }

  /// Side k, in the order that turns left.
  typename Area::Side side(int k) const {
    const Corner &from = corners_[k], &to = corners_[(k + 1) % kCorners];
    const Numbers dx = to.x - from.x, dy = to.y - from.y;
    return {counter_clockwise_ ? from.x : to.x, counter_clockwise_ ? from.y : to.y, counter_clockwise_ ? dx : -dx,
            counter_clockwise_ ? dy : -dy};
  }

  void find_lines() {
    for (int k = 0; k < kCorners; ++k) {
      const auto line = area_.line(side(k));
      side_x_[k] = __builtin_convertvector(line.x, Floats);
      side_slope_[k] = __builtin_convertvector(line.slope, Floats);
      side_is_left_[k] = line.falls;
      side_counts_[k] = line.counts;
    }
  }

  void find_plane() {
    const auto plane = area_.plane(kCorners, [&](int k) { return corners_[k]; });
    if (kOuter) known_ &= plane.usable;
    least_ = __builtin_convertvector(area_.least(), Floats);
    plane_x_ = __builtin_convertvector(plane.usable ? plane.x : Area::spread(0.0), Floats);
    plane_y_ = __builtin_convertvector(plane.usable ? plane.y : Area::spread(0.0), Floats);
    plane_constant_ = __builtin_convertvector(plane.usable ? plane.constant : area_.least(), Floats);
  }

  const OccluderImage& image_;
  const Polygons& polygons_;
  struct Corner {
    Numbers x, y, reciprocal_depth;
  } corners_[kCorners];
  Area area_;
  Mask known_, covers_, counter_clockwise_;
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
      const Lanes reciprocal_depth = Simd::add(Simd::multiply(Simd::spread(plane.x), columns), constant);
      constexpr float kLeast = 1e-30f;
      const Lanes distance = perspective
                                 ? Simd::divide(Simd::spread(1.0f), Simd::most(reciprocal_depth, Simd::spread(kLeast)))
                                 : Simd::subtract(Simd::spread(0.0f), reciprocal_depth);
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
