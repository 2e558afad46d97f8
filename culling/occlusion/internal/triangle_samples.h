// Internal: which triangles of a mesh may cover a sample of an image. See triangle_test.h for what follows.
//
// The corners' places in the image, X / W and Y / W as in screen_boxes.h, are known but for a margin: what this file
// and the shader lose, and what the rasteriser may move. A triangle with moved corners stays on one side of a line in
// the direction of an edge, where the triangle lies farther from the line than the margin, measured along the axes. So
// a sample that lies beyond such a line is not covered, whichever way the triangle faces and however thin it is.
#pragma once

#include "sightline/culling/occlusion/internal/kernels.h"

namespace sightline::culling {

/// Sixteen triangles in the image.
template <class Simd>
class ScreenTriangles {
 public:
  using Lanes = typename Simd::Lanes;

  /// `corners`: of each corner three arrays of coordinates.
  ScreenTriangles(const TriangleView& view, const float (&corners)[3][3][kLanes]) : view_(view) {
    Lanes sizes[3];
    for (int axis = 0; axis < 3; ++axis) sizes[axis] = Simd::spread(0.0f);
    Lanes w[3];
    for (int i = 0; i < 3; ++i) {
      Lanes p[3];
      for (int axis = 0; axis < 3; ++axis) {
        p[axis] = Simd::load(corners[i][axis]);
        sizes[axis] = Simd::most(sizes[axis], Simd::magnitude(p[axis]));
      }
      w[i] = value(view.w, p);
      const Lanes inverse = Simd::divide(Simd::spread(1.0f), w[i]);
      x_[i] = Simd::multiply(value(view.x, p), inverse);
      y_[i] = Simd::multiply(value(view.y, p), inverse);
    }
    const Lanes lost_w = value(view.lost_w, sizes), least_w = least_of(w);
    projects_ = ~0u;  // each corner by itself, so that none is NaN
    for (const Lanes& of_corner : w) projects_ &= Simd::less(Simd::multiply(Simd::spread(4.0f), lost_w), of_corner);
    const Lanes left = least_of(x_), right = most_of(x_), bottom = least_of(y_), top = most_of(y_);
    const Lanes farthest = Simd::most(Simd::most(Simd::magnitude(left), Simd::magnitude(right)),
                                      Simd::most(Simd::magnitude(bottom), Simd::magnitude(top)));
    const Lanes lost = Simd::add(value(view.lost_place, sizes), Simd::multiply(farthest, lost_w));
    margin_ = Simd::add(Simd::divide(Simd::multiply(Simd::spread(1.01f), lost), Simd::subtract(least_w, lost_w)),
                        Simd::add(Simd::multiply(Simd::spread(4e-7f), farthest), Simd::spread(view.snap)));
    const Lanes half_extent = Simd::add(margin_, Simd::spread(view.reach));
    columns_ = Centres(Simd::subtract(left, half_extent), Simd::add(right, half_extent), view.last_x);
    rows_ = Centres(Simd::subtract(bottom, half_extent), Simd::add(top, half_extent), view.last_y);
    const Lanes extent = Simd::add(Simd::subtract(right, left), Simd::subtract(top, bottom));
    rounding_ = Simd::multiply(Simd::spread(4.0f * 0x1p-24f), Simd::multiply(extent, extent));
  }

  /// Bit i: triangle i may cover a sample, by a face that is drawn. True of those that do not project.
  unsigned shown() const {
    unsigned found = ~(columns_.none() | rows_.none());
    if ((found & projects_ & 0xffffu) != 0) {
      const Edges edges(x_, y_);
      if (view_.fronts_alone) found &= ~faces_away(edges);
      const unsigned few = columns_.few() & rows_.few();
      if ((found & few & projects_ & 0xffffu) != 0) found &= ~few | meets_centres(edges);
    }
    return (found | ~projects_) & 0xffffu;
  }

 private:
  /// Pixel centres of the image in an interval: the last of them, and their number, which may be negative.
  struct Centres {
    Centres() = default;
    Centres(const Lanes& low, const Lanes& high, float last_centre) {
      const Lanes zero = Simd::spread(0.0f), one = Simd::spread(1.0f), end = Simd::spread(last_centre + 1.0f);
      const Lanes first = Simd::least(Simd::most(zero, low), end);  // not rounded up yet
      const Lanes last_and_one =
          Simd::add(Simd::most(Simd::spread(-1.0f), Simd::least(high, Simd::spread(last_centre))), one);
      last = Simd::subtract(Simd::whole(last_and_one), one);
      count = Simd::add(Simd::subtract(last, end), Simd::add(Simd::whole(Simd::subtract(end, first)), one));
    }
    unsigned none() const { return Simd::less(count, Simd::spread(0.5f)); }
    unsigned few() const { return Simd::less(count, Simd::spread(2.5f)); }
    unsigned several() const { return Simd::less(Simd::spread(1.5f), count); }
    Lanes last, count;
  };
  struct Edges {
    Edges(const Lanes (&x)[3], const Lanes (&y)[3]) {
      for (int i = 0; i < 3; ++i) {
        const int next = i == 2 ? 0 : i + 1;
        dx[i] = Simd::subtract(x[next], x[i]);
        dy[i] = Simd::subtract(y[next], y[i]);
      }
      area = Simd::subtract(Simd::multiply(dy[0], dx[2]), Simd::multiply(dx[0], dy[2]));
    }
    Lanes size(int i) const { return Simd::add(Simd::magnitude(dx[i]), Simd::magnitude(dy[i])); }
    Lanes dx[3], dy[3];
    Lanes area;  // twice it; positive counter-clockwise
  };

  /// a . p + constant, or what is lost of that, where p is sizes.
  static Lanes value(const float (&a)[4], const Lanes (&p)[3]) {
    return Simd::add(Simd::add(Simd::multiply(Simd::spread(a[0]), p[0]), Simd::multiply(Simd::spread(a[1]), p[1])),
                     Simd::add(Simd::multiply(Simd::spread(a[2]), p[2]), Simd::spread(a[3])));
  }
  static Lanes least_of(const Lanes (&a)[3]) { return Simd::least(Simd::least(a[0], a[1]), a[2]); }
  static Lanes most_of(const Lanes (&a)[3]) { return Simd::most(Simd::most(a[0], a[1]), a[2]); }

  /// Clockwise even after each corner has moved by the margin.
  unsigned faces_away(const Edges& edges) const {
    const Lanes moved = Simd::add(Simd::add(edges.size(0), edges.size(2)), Simd::multiply(Simd::spread(4.0f), margin_));
    const Lanes error = Simd::add(Simd::multiply(Simd::multiply(Simd::spread(2.0f), margin_), moved), rounding_);
    return Simd::less(Simd::add(edges.area, error), Simd::spread(0.0f)) & projects_;
  }

  /// Whether a sample of one of up to 2 x 2 pixels may be covered.
  unsigned meets_centres(const Edges& edges) const {
    const Lanes one = Simd::spread(1.0f);
    const Lanes x = Simd::subtract(columns_.last, one), y = Simd::subtract(rows_.last, one);
    unsigned met = meets(edges, columns_.last, rows_.last);
    const unsigned wide = columns_.several() & ~met, high = rows_.several() & ~met;
    if ((wide & 0xffffu) != 0) met |= meets(edges, x, rows_.last) & wide;
    if ((high & 0xffffu) != 0) met |= meets(edges, columns_.last, y) & high;
    if ((wide & high & 0xffffu) != 0) met |= meets(edges, x, y) & wide & high;
    return met;
  }
  unsigned meets(const Edges& edges, const Lanes& x, const Lanes& y) const {
    const Lanes zero = Simd::spread(0.0f), moved = Simd::add(margin_, Simd::spread(view_.reach));
    const Lanes low = Simd::least(zero, edges.area), high = Simd::most(zero, edges.area);
    unsigned beyond = 0;
    for (int i = 0; i < 3; ++i) {
      const Lanes from_edge = Simd::subtract(Simd::multiply(edges.dx[i], Simd::subtract(y, y_[i])),
                                             Simd::multiply(edges.dy[i], Simd::subtract(x, x_[i])));
      const Lanes error = Simd::add(Simd::multiply(moved, edges.size(i)), rounding_);
      beyond |= Simd::less(from_edge, Simd::subtract(low, error)) | Simd::less(Simd::add(high, error), from_edge);
    }
    return ~beyond;
  }

  const TriangleView& view_;
  Lanes x_[3], y_[3];
  Lanes margin_;    // pixels by which a corner may be elsewhere, along each axis
  Lanes rounding_;  // of cross products of edges
  Centres columns_, rows_;
  unsigned projects_;
};

/// OcclusionKernels::shown_triangles.
template <class Simd>
std::size_t shown_triangles(const TriangleView& view, const float* positions, const std::uint32_t* indices,
                            std::size_t count, std::uint32_t* shown) {
  alignas(64) float corners[3][3][kLanes] = {};
  const std::uint32_t* const begin = shown;
  for (std::size_t done = 0; done < count; done += kLanes, indices += 3 * kLanes) {
    const std::size_t left = count - done;
    const int used = left < kLanes ? int(left) : kLanes;
    for (int lane = 0; lane < used; ++lane)
      for (int i = 0; i < 3; ++i) {
        const float* position = positions + 3 * std::size_t(indices[3 * lane + i]);
        for (int axis = 0; axis < 3; ++axis) corners[i][axis][lane] = position[axis];
      }
    const unsigned bits = ScreenTriangles<Simd>(view, corners).shown();
    for (int lane = 0; lane < used; ++lane) {  // without branches: the next one overwrites what is not shown
      for (int i = 0; i < 3; ++i) shown[i] = indices[3 * lane + i];
      shown += 3 * (bits >> lane & 1u);
    }
  }
  return std::size_t(shown - begin);
}

}  // namespace sightline::culling
