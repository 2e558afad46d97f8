// Internal: which samples of an image a box may cover, and how near it may be. See sample_test.h for what follows.
//
// Let X, Y and W be linear forms such that X / W and Y / W are the place of a point in the image, in pixels, with
// pixel centres at integers. Where W > 0 all over a box, X / W and Y / W take their least and greatest values in the
// box's corners. The rectangle of the eight corners contains the whole projection, after three errors are added:
//   - A form's value is a sum of four products. Coefficients, products and sums are rounded, so its error is at most
//     B = 8 u (|a x| + |b y| + |c z| + |d|), u = 2^-24, and what d has lost before.
//   - The quotient q is off by at most (Bx + |q| Bw) / (W - Bw) from the forms, and by 3 u |q| from its own rounding.
//   - A rasteriser may move vertices: ScreenView::snap.
// Where W may be 0 or less in a box, or a product may overflow, the rectangle is the whole image.
//
// Simd::Lanes holds sixteen floats. least() and most() are a < b ? a : b and a < b ? b : a, so every instruction set
// gives the same answer.
#pragma once

#include <limits>

#include "sightline/culling/occlusion/internal/kernels.h"

namespace sightline::culling {

/// A linear form's parts at the low and high coordinates of the boxes.
template <class Simd>
struct BoxForm {
  using Lanes = typename Simd::Lanes;
  BoxForm(const LinearForm& f, const Lanes (&low)[3], const Lanes (&high)[3]) {
    const Lanes d = Simd::spread(f.d);
    x[0] = Simd::multiply(Simd::spread(f.x), low[0]);
    x[1] = Simd::multiply(Simd::spread(f.x), high[0]);
    y[0] = Simd::multiply(Simd::spread(f.y), low[1]);
    y[1] = Simd::multiply(Simd::spread(f.y), high[1]);
    z[0] = Simd::add(Simd::multiply(Simd::spread(f.z), low[2]), d);
    z[1] = Simd::add(Simd::multiply(Simd::spread(f.z), high[2]), d);
  }
  Lanes at(int i, int j, int k) const { return Simd::add(Simd::add(x[i], y[j]), z[k]); }
  /// The least of at(): rounding keeps order.
  Lanes least() const {
    return Simd::add(Simd::add(Simd::least(x[0], x[1]), Simd::least(y[0], y[1])), Simd::least(z[0], z[1]));
  }
  Lanes x[2], y[2], z[2];
};

/// Projects sixteen boxes.
template <class Simd>
class ScreenBoxes {
 public:
  using Lanes = typename Simd::Lanes;
  using Form = BoxForm<Simd>;

  ScreenBoxes(const ScreenView& view, const float* const (&c)[6])
      : ScreenBoxes(view, c, [](int, const Lanes&, const Lanes&) {}) {}

  /// Calls see(corner, x, y) with the places of the boxes' corners. Bits of `corner`: high x, y, z.
  template <class See>
  ScreenBoxes(const ScreenView& view, const float* const (&c)[6], See&& see) {
    Lanes low[3], high[3], sizes[3];
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = Simd::load(c[axis]);
      high[axis] = Simd::load(c[axis + 3]);
      sizes[axis] = Simd::most(Simd::magnitude(low[axis]), Simd::magnitude(high[axis]));
    }
    const unsigned ordered =
        Simd::at_most(low[0], high[0]) & Simd::at_most(low[1], high[1]) & Simd::at_most(low[2], high[2]);
    empty_ = Simd::less(high[0], low[0]) | Simd::less(high[1], low[1]) | Simd::less(high[2], low[2]);
    const Form x(view.x, low, high), y(view.y, low, high), w(view.w, low, high), t(view.t, low, high);
    for (int corner = 0; corner < 8; ++corner) {
      const int i = corner & 1, j = corner >> 1 & 1, k = corner >> 2;
      const Lanes inverse = Simd::divide(Simd::spread(1.0f), w.at(i, j, k));
      const Lanes px = Simd::multiply(x.at(i, j, k), inverse), py = Simd::multiply(y.at(i, j, k), inverse);
      see(corner, px, py);
      left_ = corner == 0 ? px : Simd::least(left_, px);
      right_ = corner == 0 ? px : Simd::most(right_, px);
      bottom_ = corner == 0 ? py : Simd::least(bottom_, py);
      top_ = corner == 0 ? py : Simd::most(top_, py);
    }
    const Lanes least_w = w.least();
    const Lanes band_w = band(view.w, sizes);
    const Lanes largest = Simd::spread(view.largest);
    const unsigned finite =
        Simd::less(sizes[0], largest) & Simd::less(sizes[1], largest) & Simd::less(sizes[2], largest);
    projects_ = ordered & finite & Simd::less(Simd::multiply(Simd::spread(4.0f), band_w), least_w);
    const Lanes per_w = Simd::divide(Simd::spread(1.01f), Simd::subtract(least_w, band_w));
    widen(left_, right_, band(view.x, sizes), band_w, per_w, view.snap);
    widen(bottom_, top_, band(view.y, sizes), band_w, per_w, view.snap);
    nearest_ = Simd::subtract(t.least(), band(view.t, sizes));
  }

  /// Bit i: box i may cover a sample of the image. A box with a NaN neither is empty nor projects: it covers all.
  unsigned covering(const ScreenView& view) const {
    unsigned found = 0;
    for (int s = 0; s < view.sample_count; ++s)
      found |= ~(between_samples(left_, right_, view.samples[s][0], view.last_x) |
                 between_samples(bottom_, top_, view.samples[s][1], view.last_y));
    return ((found & projects_) | (~projects_ & ~empty_)) & 0xffffu;
  }

  void store(const ScreenView& view, BoxRectangles& out) const {
    out.covering = covering(view);
    Simd::store(out.left, left_);
    Simd::store(out.right, right_);
    Simd::store(out.bottom, bottom_);
    Simd::store(out.top, top_);
    Simd::store(out.nearest, nearest_);
    out.projects = projects_;
  }

  /// OcclusionKernels::areas: infinite for boxes that do not project, 0 for empty ones. An area of `solids` counts
  /// where, facing the eye at the box's centre, it takes fewer pixels than the outline.
  static void store_areas(const ScreenView& view, const float* const (&c)[6], const float* solids, float* areas) {
    Outlines outlines;
    const ScreenBoxes boxes(view, c, outlines);
    const Lanes area = outlines.area();
    boxes.store_areas(solids == nullptr ? area : Centres(view, c).limited(solids, area), areas);
  }

  /// See OcclusionKernels::splats.
  static void store_splats(const ScreenView& view, const float* const (&c)[6], const float* solids, float least_area,
                           bool all, BoxSplats& out) {
    constexpr float kMoved = 0.01f;  // pixels by which a square may be drawn elsewhere
    Outlines outlines;
    const ScreenBoxes boxes(view, c, outlines);
    const Centres centres(view, c);
    const Lanes outline = outlines.area(), area = solids == nullptr ? outline : centres.limited(solids, outline);
    boxes.store_areas(area, out.area);
    Simd::store(out.x, centres.x);
    Simd::store(out.y, centres.y);
    Simd::store(out.distance, centres.distance);
    const Lanes none = Simd::spread(0.0f), half = Simd::spread(0.5f);
    const auto in_image = [&](const Lanes& at, float last) {
      return Simd::at_most(none, Simd::add(at, half)) & Simd::at_most(at, Simd::spread(last + 0.5f));
    };
    out.showing = boxes.projects_ & Simd::less(none, area) & in_image(centres.x, view.last_x) &
                  in_image(centres.y, view.last_y) & 0xffffu;
    if (all) return;
    const Lanes side = Simd::root(Simd::most(area, Simd::spread(least_area)));
    const Lanes half_extent = Simd::add(Simd::multiply(half, side), Simd::spread(kMoved));
    const auto between = [&](const Lanes& at, float last) {
      return between_samples(Simd::subtract(at, half_extent), Simd::add(at, half_extent), 0.0f, last);
    };
    out.showing &= ~(between(centres.x, view.last_x) | between(centres.y, view.last_y));
  }

 private:
  /// Sees the corners of boxes.
  struct Outlines {
    void operator()(int corner, const Lanes& x, const Lanes& y) { px[corner] = x, py[corner] = y; }
    Lanes area() const {
      // Half the cross product of a face's diagonals is its area.
      constexpr int kFaces[6][4] = {{0, 2, 6, 4}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 3, 7, 6}, {0, 1, 3, 2}, {4, 5, 7, 6}};
      Lanes sum = Simd::spread(0.0f);
      for (const auto& f : kFaces) {
        const Lanes ax = Simd::subtract(px[f[2]], px[f[0]]), ay = Simd::subtract(py[f[2]], py[f[0]]);
        const Lanes bx = Simd::subtract(px[f[3]], px[f[1]]), by = Simd::subtract(py[f[3]], py[f[1]]);
        sum = Simd::add(sum, Simd::magnitude(Simd::subtract(Simd::multiply(ax, by), Simd::multiply(ay, bx))));
      }
      return Simd::multiply(Simd::spread(0.25f), sum);
    }
    Lanes px[8], py[8];
  };

  /// The middles of boxes.
  struct Centres {
    Centres(const ScreenView& view, const float* const (&c)[6]) {
      for (int axis = 0; axis < 3; ++axis)
        at[axis] = Simd::multiply(Simd::spread(0.5f), Simd::add(Simd::load(c[axis]), Simd::load(c[axis + 3])));
      inverse = Simd::divide(Simd::spread(1.0f), value(view.w));
      x = Simd::multiply(value(view.x), inverse);
      y = Simd::multiply(value(view.y), inverse);
      distance = value(view.t);
      Lanes square = Simd::spread(0.0f);
      for (int axis = 0; axis < 3; ++axis) {
        const Lanes part = Simd::add(
            Simd::add(Simd::spread(view.facing[0][axis]), Simd::multiply(x, Simd::spread(view.facing[1][axis]))),
            Simd::multiply(y, Simd::spread(view.facing[2][axis])));
        square = Simd::add(square, Simd::multiply(part, part));
      }
      per_metre = Simd::multiply(Simd::root(square), Simd::multiply(inverse, inverse));
    }
    Lanes value(const LinearForm& f) const {
      return Simd::add(Simd::add(Simd::multiply(Simd::spread(f.x), at[0]), Simd::multiply(Simd::spread(f.y), at[1])),
                       Simd::add(Simd::multiply(Simd::spread(f.z), at[2]), Simd::spread(f.d)));
    }
    /// Pixels of solids with so many square metres; `most` where theirs are more, or not a number.
    Lanes limited(const float* solids, const Lanes& most) const {
      return Simd::least(Simd::multiply(Simd::load(solids), per_metre), most);
    }
    Lanes at[3], inverse, x, y, distance;
    Lanes per_metre;  // pixels of a square metre that faces the eye
  };

  /// Infinity for boxes that do not project, 0 for empty ones.
  void store_areas(const Lanes& own, float* areas) const {
    constexpr float kInfinite = std::numeric_limits<float>::infinity();
    Simd::store(areas, own);
    for (int i = 0; i < kLanes; ++i)
      if ((projects_ >> i & 1u) == 0) areas[i] = (empty_ >> i & 1u) != 0 ? 0.0f : kInfinite;
  }

  /// B of the comment above, for coordinates of these sizes.
  static Lanes band(const LinearForm& f, const Lanes (&sizes)[3]) {
    constexpr float kUnits = 8.0f * 0x1p-24f, kTiny = 1e-36f;  // kTiny: more than what underflow loses
    const auto part = [](float factor, const Lanes& size) {
      return Simd::multiply(Simd::spread(kUnits * (factor < 0.0f ? -factor : factor)), size);
    };
    const float constant = f.error + kTiny + kUnits * (f.d < 0.0f ? -f.d : f.d);
    return Simd::add(Simd::add(part(f.x, sizes[0]), part(f.y, sizes[1])),
                     Simd::add(part(f.z, sizes[2]), Simd::spread(constant)));
  }

  static void widen(Lanes& low, Lanes& high, const Lanes& band, const Lanes& band_w, const Lanes& per_w, float snap) {
    const Lanes farthest = Simd::most(Simd::magnitude(low), Simd::magnitude(high));
    const Lanes of_forms = Simd::multiply(Simd::add(band, Simd::multiply(farthest, band_w)), per_w);
    const Lanes half_extent =
        Simd::add(Simd::add(of_forms, Simd::multiply(Simd::spread(4e-7f), farthest)), Simd::spread(snap));
    low = Simd::subtract(low, half_extent);
    high = Simd::add(high, half_extent);
  }

  /// Bit i: no sample place lies within the interval i: neither 0 + offset nor 1 + offset nor … last + offset.
  static unsigned between_samples(const Lanes& low, const Lanes& high, float offset, float last) {
    const Lanes o = Simd::spread(offset);
    const Lanes from = Simd::most(Simd::subtract(low, o), Simd::spread(0.0f));
    const Lanes to = Simd::most(Simd::least(Simd::subtract(high, o), Simd::spread(last)), Simd::spread(-1.0f));
    return Simd::less(to, from) | Simd::less(Simd::whole(to), from);
  }

  Lanes left_, right_, bottom_, top_, nearest_;
  unsigned projects_, empty_;
};

}  // namespace sightline::culling
