// Internal to gpuprims: the start that all reference intersections share, and the intervals they clip.
//
// A ray is moved to its point closest to the primitive's centre and given unit length, so that what follows works with
// numbers of the primitive's size, however far the eye and however long the direction. Haines et al., "Precision
// Improvements for Ray/Sphere Intersection", Ray Tracing Gems (2019), chapter 7, show why.
#pragma once

#include <cmath>
#include <limits>

#include "sightline/gpuprims/ray.h"

namespace sightline::gpuprims {

using core::dvec2;

/// origin + s * direction with unit direction; the original parameter is start + s * scale.
struct LocalRay {
  dvec3 origin{0.0};
  dvec3 direction{0.0};
  double start = 0.0;
  double scale = 0.0;
  bool valid = false;  ///< false for rays that are not finite or have no direction: they hit nothing

  double t(double s) const { return start + s * scale; }
};

/// The ray about its point closest to the local origin. The new origin lies on the given ray exactly at `start`, up to
/// one rounding per coordinate (fused multiply-add), so nothing of the eye's distance is lost. Directions of any length
/// that double can hold; origins up to 1e150.
inline LocalRay closest_approach(const Ray& ray) {
  LocalRay local;
  const dvec3& o = ray.origin;
  dvec3 d = ray.direction;
  const double size = std::fmax(std::fabs(d.x), std::fmax(std::fabs(d.y), std::fabs(d.z)));
  if (!(size > 0.0 && size < std::numeric_limits<double>::infinity())) return local;
  int exponent = 0;  // a power of two scales without rounding
  if (size < 1e-100 || size > 1e100) {
    exponent = std::ilogb(size);
    for (int i = 0; i < 3; ++i) d[i] = std::ldexp(d[i], -exponent);
  }
  const double square = glm::dot(d, d), length = std::sqrt(square);
  const double start = -glm::dot(o, d) / square;
  local.origin = {std::fma(start, d.x, o.x), std::fma(start, d.y, o.y), std::fma(start, d.z, o.z)};
  local.direction = d / length;
  local.start = std::ldexp(start, -exponent);
  local.scale = std::ldexp(1.0 / length, -exponent);
  local.valid = glm::dot(local.origin, local.origin) + std::fabs(start) < std::numeric_limits<double>::infinity();
  return local;
}

/// a.x b.y - a.y b.x to within 2 ulps (Kahan's difference of products; Jeannerod, Louvet, Muller, "Further analysis of
/// Kahan's algorithm", Math. Comp. 82, 2013): small against the terms where a ray passes close to an axis.
inline double cross(const dvec2& a, const dvec2& b) {
  const double w = a.y * b.x;
  return std::fma(a.x, b.y, -w) + std::fma(-a.y, b.x, w);
}

/// A closed interval of s and the faces that bound it. Default: the whole line.
struct Span {
  static constexpr int kNoFace = -1;
  double from = -std::numeric_limits<double>::infinity(), to = std::numeric_limits<double>::infinity();
  int from_face = kNoFace, to_face = kNoFace;

  bool empty() const { return !(from <= to); }
  void enter(double s, int face) {
    if (s > from) from = s, from_face = face;
  }
  void leave(double s, int face) {
    if (s < to) to = s, to_face = face;
  }
  void clear() { from = 1.0, to = 0.0; }

  /// Keeps value + s * slope >= 0.
  void clip(double value, double slope, int face) {
    if (slope > 0.0) {
      enter(-value / slope, face);
    } else if (slope < 0.0) {
      leave(-value / slope, face);
    } else if (!(value >= 0.0)) {
      clear();
    }
  }
};

}  // namespace sightline::gpuprims
