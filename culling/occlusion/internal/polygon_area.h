// Internal: the area of the image that a convex polygon covers, for one polygon or for several at once. The occluder
// raster takes it for outlines of solids and for triangles; the kernels of polygons of a fixed number of corners, eight
// at a time (cover_polygons.h). Why it is safe is said in occluder_raster.h.
#pragma once

#include "sightline/culling/frustum/hierarchy.h"
#include "sightline/culling/occlusion/internal/occluder_area.h"

namespace sightline::culling::raster {

/// Pixels that lie within for certain, and no nearer than there, or, if kOuter, all that may lie within, and no
/// farther. Numbers: a double, or a vector of them with an entry for each polygon. Local: a type of the including
/// file's anonymous namespace, so that every instance is local to the file, as kernels need it. Call the functions in
/// their order.
template <class Local, class Numbers, bool kOuter>
class PolygonArea {
 public:
  using Mask = decltype(Numbers{} < Numbers{});  // of a vector: all bits of an entry, or none
  static constexpr double kInwards = kOuter ? -1.0 : 1.0;

  static Numbers spread(double a) { return Numbers{} + a; }
  static Numbers greater(const Numbers& a, const Numbers& b) { return a < b ? b : a; }
  static Numbers lesser(const Numbers& a, const Numbers& b) { return b < a ? b : a; }
  static Numbers magnitude(const Numbers& a) {
    if constexpr (kOne)
      return __builtin_fabs(a);
    else
      return __builtin_bit_cast(Numbers, __builtin_bit_cast(Mask, a) & 0x7fffffffffffffff);
  }

  // --- the corners ---

  /// A corner of all polygons: its place, reciprocal depth, and by how much the place may be off.
  void add(const Numbers& x, const Numbers& y, const Numbers& reciprocal_depth, const Numbers& error) {
    error_ = greater(error_, error);
    farthest_ = lesser(farthest_, reciprocal_depth);
    left_ = lesser(left_, x), right_ = greater(right_, x);
    bottom_ = lesser(bottom_, y), top_ = greater(top_, y);
  }
  const Numbers& error() const { return error_; }

  /// Finds the pixels around the corners. Returns where there are any. `shift`: pixels by which a rasteriser may move a
  /// corner.
  Mask find_pixels(int width, int height, double shift) {
    constexpr double kMostFloatLost = 0x1p-6;
    const Numbers grown = kOuter ? error_ + shift + kMostFloatLost : spread(0.0);
    Numbers first_column;
    whole_between(left_ - grown, right_ + grown, width, first_column, last_column_);
    whole_between(bottom_ - grown, top_ + grown, height, first_row_, last_row_);
    column_ = towards_zero(first_column * (1.0 / kLanes)) * double(kLanes);
    columns_ = last_column_ - column_ + 1.0;
    const Numbers float_lost = 0x1p-21 * (greater(columns_, last_row_ - first_row_) + 2.0);
    shifted_ = error_ + shift;
    inset_ = shifted_ + float_lost;
    return (first_column <= last_column_) & (first_row_ <= last_row_);
  }

  // --- the sides, which turn left around the polygon ---

  struct Side {
    Numbers x, y, dx, dy;
  };
  /// Sides that are nearly level limit the rows. They must be known first, since other sides count from the first row.
  static Mask level(const Side& s) { return magnitude(s.dx) > kSteepest * magnitude(s.dy); }

  void limit_rows(const Side& s) {
    const Mask is_level = level(s);
    const Numbers slope = s.dy / s.dx, margin = kInwards * inset_ * (1.0 + magnitude(slope));
    const Numbers a = s.y + slope * (column_ - s.x), b = s.y + slope * (last_column_ - s.x);
    const Numbers lowest = (kOuter ? lesser(a, b) : greater(a, b)) + margin;
    const Numbers highest = (kOuter ? greater(a, b) : lesser(a, b)) - margin;
    const Mask forwards = s.dx > 0.0;
    const Numbers low = forwards ? greater(first_row_, lowest) : first_row_;
    const Numbers high = forwards ? last_row_ : lesser(last_row_, highest);
    first_row_ = is_level ? low : first_row_;
    last_row_ = is_level ? high : last_row_;
  }
  /// Takes the whole rows within these limits. Returns where there are any.
  Mask take_rows(int height) {
    const Numbers low = first_row_, high = last_row_;
    whole_between(low, high, height, first_row_, last_row_);
    rows_ = last_row_ - first_row_ + 1.0;
    return first_row_ <= last_row_;
  }

  /// Where a side crosses the middle of the first row, in columns to the right of column -1. It falls where it is on
  /// the left, and limits nothing where it does not count.
  struct Line {
    Numbers x, slope;
    Mask falls, counts;
  };
  Line line(const Side& s) const {
    const Numbers slope = s.dx / s.dy, margin = kInwards * inset_ * (1.0 + magnitude(slope));
    const Numbers x = s.x + (first_row_ - s.y) * slope - (column_ - 1.0);
    const Mask falls = s.dy < 0.0;
    return {falls ? x + margin : x - margin, slope, falls, (level(s) | (s.dy == 0.0)) == Mask{}};
  }

  // --- how near it is ---

  /// The diagonals of a face of four corners, two sides of a triangle, and something alike of any other: their cross
  /// product has the sign of the area.
  struct Diagonals {
    Numbers x1, y1, n1, x2, y2, n2, area;
    /// The area is below 0, or above, for certain where it exceeds this.
    Numbers open(const Numbers& error) const {
      const Numbers first = magnitude(x1) + magnitude(y1), second = magnitude(x2) + magnitude(y2);
      return 8.0 * error * (first + second) + kLost * first * second;
    }
  };
  /// at(i): corner i of `count`, with its x, y and reciprocal depth.
  template <class At>
  static Diagonals diagonals(int count, const At& at) {
    const auto a = at(0), b = at(count / 2), c = at(count / 4), d = at(3 * count / 4);
    Diagonals s{b.x - a.x, b.y - a.y, b.reciprocal_depth - a.reciprocal_depth,
                d.x - c.x, d.y - c.y, d.reciprocal_depth - c.reciprocal_depth,
                {}};
    s.area = s.x1 * s.y2 - s.x2 * s.y1;
    return s;
  }

  /// Reciprocal depth all over the area.
  Numbers least() const { return farthest_ - 0x1p-22 * magnitude(farthest_) - 1e-36; }

  /// Reciprocal depth of a face, a linear function of column and row, moved until it holds for all of its corners, for
  /// what these may be off, and for its own error in float.
  struct Plane {
    Numbers x, y, constant;
    Mask usable;
  };
  template <class At>
  Plane plane(int count, const At& at) const {
    const Diagonals s = diagonals(count, at);
    const Numbers x = (s.n1 * s.y2 - s.n2 * s.y1) / s.area, y = (s.x1 * s.n2 - s.x2 * s.n1) / s.area;
    Numbers constant = spread(kInwards * kLarge);
    for (int k = 0; k < count; ++k) {
      const auto c = at(k);
      const Numbers at_corner = c.reciprocal_depth - x * (c.x - column_) - y * (c.y - first_row_);
      constant = kOuter ? greater(constant, at_corner) : lesser(constant, at_corner);
    }
    const Numbers off =
        shifted_ + kPlaceLost * (magnitude(left_) + magnitude(right_) + magnitude(bottom_) + magnitude(top_));
    constant -= kInwards * (magnitude(x) + magnitude(y)) * off;
    constant -= kInwards * (0x1p-21 * (magnitude(x) * columns_ + magnitude(y) * rows_ + magnitude(constant)) + 1e-36);
    return {x, y, constant, Mask((magnitude(x) < kLarge) & (magnitude(y) < kLarge) & (magnitude(constant) < kLarge))};
  }

  // --- the answer ---

  const Numbers& column() const { return column_; }
  const Numbers& columns() const { return columns_; }
  const Numbers& first_row() const { return first_row_; }
  const Numbers& rows() const { return rows_; }

 private:
  static constexpr bool kOne = sizeof(Numbers) == sizeof(double);

  static Numbers towards_zero(const Numbers& a) {
    if constexpr (kOne) {
      return double(int(a));
    } else {
      typedef int Whole __attribute__((vector_size(sizeof(Numbers) / sizeof(double) * sizeof(int))));
      return __builtin_convertvector(__builtin_convertvector(a, Whole), Numbers);
    }
  }
  /// The first whole number not below `from` and the last not above `to`, of 0 … size - 1. None: first > last. Without
  /// std::ceil, which is a function call where the instruction set has no rounding.
  static void whole_between(Numbers from, Numbers to, int size, Numbers& first, Numbers& last) {
    from = greater(from, spread(0.0)), to = lesser(to, spread(double(size - 1)));
    const Mask some = from <= to;
    const Numbers low = some ? from : spread(0.0), high = some ? to : spread(-1.0);
    const Numbers below = towards_zero(low);
    first = below + (below < low ? spread(1.0) : spread(0.0));
    last = towards_zero(high);
  }

  Numbers error_ = spread(0.0), farthest_ = spread(kLarge);
  Numbers left_ = spread(kLarge), right_ = spread(-kLarge), bottom_ = spread(kLarge), top_ = spread(-kLarge);
  Numbers column_, last_column_, columns_, first_row_, last_row_, rows_;
  Numbers shifted_, inset_;  // by these the area is smaller, or, if kOuter, larger
};

}  // namespace sightline::culling::raster
