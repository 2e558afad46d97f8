// Axis-aligned boxes, and the outward rounding that keeps a float box around its double original.
#pragma once

#include <bit>
#include <cstdint>
#include <limits>

#include "sightline/core/api.h"
#include "sightline/core/conventions.h"

namespace sightline::core {

/// Closed box in double precision. Default-constructed: empty (min > max), the neutral element of grow().
struct AabbD {
  dvec3 min{std::numeric_limits<double>::infinity()};
  dvec3 max{-std::numeric_limits<double>::infinity()};

  bool empty() const { return !(min.x <= max.x && min.y <= max.y && min.z <= max.z); }
  void grow(const dvec3& p) { min = glm::min(min, p), max = glm::max(max, p); }
  void grow(const AabbD& b) { min = glm::min(min, b.min), max = glm::max(max, b.max); }
  dvec3 centre() const { return 0.5 * min + 0.5 * max; }
  dvec3 size() const { return empty() ? dvec3(0.0) : max - min; }
};

/// Closed box in float, as snapshots store it. The empty box is (+kFar, -kFar): finite, so that no plane test yields
/// NaN.
struct Aabb {
  static constexpr float kFar = 3.0e38f;
  vec3 min{kFar};
  vec3 max{-kFar};

  bool empty() const { return !(min.x <= max.x && min.y <= max.y && min.z <= max.z); }
  void grow(const Aabb& b) { min = glm::min(min, b.min), max = glm::max(max, b.max); }
};

/// The largest double below x, as std::nextafter gives it, but without the call. Minus infinity and NaN are returned
/// unchanged.
inline double next_below(double x) {
  if (!(x > -std::numeric_limits<double>::infinity())) return x;
  if (x == 0.0) return -std::numeric_limits<double>::denorm_min();
  return std::bit_cast<double>(std::bit_cast<std::int64_t>(x) + (x > 0.0 ? -1 : 1));
}

// The next functions are out of line, so that an application's compiler cannot change their results. It may contract x
// * y - z, and g++ 12 drops the rounding of neighbouring double(float(x)). The library's own flags
// (cmake/SightlineTargets.cmake) prevent that.

/// Largest float <= x. Returns kFar for x >= Aabb::kFar, and the lowest float for x <= -kFar: both err outwards or
/// concern coordinates that commit() refuses.
SIGHTLINE_API float round_down(double x);
/// Smallest float >= x; see round_down.
SIGHTLINE_API float round_up(double x);
/// The smallest float box around `box - origin`, rounded outwards including the subtraction's own rounding error.
SIGHTLINE_API Aabb round_outwards(const AabbD& box, const dvec3& origin);

}  // namespace sightline::core
