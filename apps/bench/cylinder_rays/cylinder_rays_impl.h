// The loop of cylinder_rays.h, which the compiler vectorises. Each file that includes this header is compiled for its
// own instruction set. So everything here is local to that file and calls nothing from other headers: a copy made there
// could be linked into code for every processor. Internal.
#pragma once

#include "sightline/apps/bench/cylinder_rays/cylinder_rays_kernel.h"

#ifndef __GNUC__
#include <cmath>
#endif

namespace sightline::bench {
namespace {

#ifdef __GNUC__
inline double fused(double a, double b, double c) {
  return __builtin_fma(a, b, c);
}
inline double root(double x) {
  return __builtin_sqrt(x);
}
inline double magnitude(double x) {
  return __builtin_fabs(x);
}
#else
inline double fused(double a, double b, double c) {
  return std::fma(a, b, c);
}
inline double root(double x) {
  return std::sqrt(x);
}
inline double magnitude(double x) {
  return std::fabs(x);
}
#endif
inline double larger(double a, double b) {
  return a < b ? b : a;
}
inline double smaller(double a, double b) {
  return b < a ? b : a;
}

/// cylinder.cpp, cylinder_span() and Span::clip_slab() in one function without branches.
inline void first_crossings(const CylinderRays& in) {
  const double *const ox = in.origin[0], *const oy = in.origin[1], *const oz = in.origin[2];
  const double *const dx = in.direction[0], *const dy = in.direction[1], *const dz = in.direction[2];
  const double *const t_min = in.t_min, infinity = in.infinity;
  double* const t = in.t;
  const double radius2 = in.radius * in.radius, weight = in.weight, slab = in.half, nearly_parallel = in.least;
  const double level_reach = slab == 0.0 ? -1.0 : slab;  // a disc seen edge on shows nothing
  // An open end moves its crossing to infinity.
  const double bottom = in.bottom_open ? infinity : 0.0, top = in.top_open ? infinity : 0.0;
  for (std::size_t i = 0; i < in.count; ++i) {
    const double across = dx[i] * dx[i] + dy[i] * dy[i], wdz = weight * dz[i];
    const double start = -((dx[i] * ox[i] + dy[i] * oy[i]) + wdz * oz[i]) / (across + wdz * dz[i]);
    const double x = fused(start, dx[i], ox[i]), y = fused(start, dy[i], oy[i]), z = fused(start, dz[i], oz[i]);

    const double moment = x * dy[i] - y * dx[i], b = x * dx[i] + y * dy[i];
    const double discriminant = radius2 * across - moment * moment, half = root(larger(discriminant, 0.0));
    const bool parallel = !(across > nearly_parallel);
    const double inverse = 1.0 / (parallel ? 1.0 : across);
    const double room = parallel ? radius2 - (x * x + y * y) : discriminant;
    const double side_from = parallel ? -infinity : (-b - half) * inverse;
    const double side_to = parallel ? infinity : (-b + half) * inverse;

    const bool level = dz[i] == 0.0;
    const double rise = 1.0 / (level ? 1.0 : dz[i]), middle = -z * rise, extent = slab * magnitude(rise);
    const double least_room = smaller(room, level ? level_reach - magnitude(z) : room);
    const double slab_from = level ? -infinity : middle - extent, slab_to = level ? infinity : middle + extent;

    const double from = larger(side_from, slab_from), to = smaller(side_to, slab_to);
    const double below = dz[i] > 0.0 ? bottom : top, above = dz[i] > 0.0 ? top : bottom;
    const double first = (start + from) + (slab_from > side_from ? below : 0.0);
    const double last = (start + to) + (slab_to < side_to ? above : 0.0);
    const double seen = smaller(first >= t_min[i] ? first : infinity, last >= t_min[i] ? last : infinity);
    t[i] = ((least_room >= 0.0) & (from <= to)) ? seen : infinity;
  }
}

}  // namespace
}  // namespace sightline::bench
