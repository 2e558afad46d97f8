// Cuts spans by the sweep of both tori, 0 <= phi <= angle about z. `angle` is core::sweep_angle() of their parameter.
// Internal to gpuprims.
#pragma once

#include <numbers>

#include "sightline/core/primitive.h"
#include "sightline/gpuprims/internal/local_ray.h"

namespace sightline::gpuprims {

/// kBottom is the end at angle 0, kTop the one at `angle`.
class Wedge {
 public:
  /// A wedge of core::kFullTurn has no ends.
  explicit Wedge(double angle) : whole_(angle == core::kFullTurn) {
    if (whole_) return;
    const double c = std::cos(0.5 * angle), s = std::sin(0.5 * angle);
    convex_ = angle <= std::numbers::pi;
    flat_ = angle == 0.0;
    middle_ = {c, s};
    end_ = {(c - s) * (c + s), 2.0 * s * c};
  }

  /// Outward normal of an end.
  dvec3 normal(int face) const { return face == kBottom ? dvec3(0, -1, 0) : dvec3(-end_.y, end_.x, 0); }

  /// The parts of `span` within the wedge, in rising order; returns their number, 0 to 2. A wedge of angle 0 leaves one
  /// point with both faces, and nothing of a ray within it.
  int cut(const dvec3& o, const dvec3& u, const Span& span, Span pieces[2]) const {
    if (whole_) {
      pieces[0] = span;
      return 1;
    }
    // Distances to the two half-planes, positive on the wedge's side.
    const double start = o.y, start_slope = u.y;
    const double end = end_.y * o.x - end_.x * o.y, end_slope = end_.y * u.x - end_.x * u.y;
    if (!convex_) {  // the gap is convex and open: a ray along the axis is in the wedge
      if ((start_slope == 0 && start >= 0) || (end_slope == 0 && end >= 0)) return pieces[0] = span, 1;
      Span gap;
      gap.clip(-start, -start_slope, kBottom);
      gap.clip(-end, -end_slope, kTop);
      return subtract(span, gap, pieces);
    }
    if (flat_ && start_slope == 0) return 0;
    Span& piece = pieces[0] = span;
    piece.clip(start, start_slope, kBottom);
    piece.clip(end, end_slope, kTop);
    if (piece.empty()) return 0;
    const double s = 0.5 * (piece.from + piece.to);
    // Rounding errors may leave a part opposite a thin wedge.
    return (o.x + s * u.x) * middle_.x + (o.y + s * u.y) * middle_.y >= 0 ? 1 : 0;
  }

 private:
  bool whole_, convex_ = false, flat_ = false;
  dvec2 middle_{}, end_{};
};

}  // namespace sightline::gpuprims
