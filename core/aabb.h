// Axis-aligned boxes, and the outward rounding that keeps a float box around its double original.
#pragma once

#include <bit>
#include <cstdint>
#include <limits>

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

/// The number before x, as std::nextafter gives it, without the call. Minus infinity and NaN stay.
inline float next_below(float x) {
  if (!(x > -std::numeric_limits<float>::infinity())) return x;
  if (x == 0.0f) return -std::numeric_limits<float>::denorm_min();
  return std::bit_cast<float>(std::bit_cast<std::int32_t>(x) + (x > 0.0f ? -1 : 1));
}
inline double next_below(double x) {
  if (!(x > -std::numeric_limits<double>::infinity())) return x;
  if (x == 0.0) return -std::numeric_limits<double>::denorm_min();
  return std::bit_cast<double>(std::bit_cast<std::int64_t>(x) + (x > 0.0 ? -1 : 1));
}

/// Largest float <= x. From Aabb::kFar upwards it stays kFar, from -kFar downwards it is the lowest float: both err
/// outwards or concern coordinates that commit() refuses.
inline float round_down(double x) {
  if (x >= double(Aabb::kFar)) return Aabb::kFar;
  if (x <= -double(Aabb::kFar)) return -std::numeric_limits<float>::max();
  const float f = static_cast<float>(x);
  return double(f) <= x ? f : next_below(f);
}

/// Smallest float >= x; see round_down.
inline float round_up(double x) {
  return -round_down(-x);
}

/// The smallest float box around `box - origin`, rounded outwards including the subtraction's own rounding error.
inline Aabb round_outwards(const AabbD& box, const dvec3& origin) {
  if (box.empty()) return {};
  Aabb out;
  for (int i = 0; i < 3; ++i) {
    const double lo = box.min[i] - origin[i], hi = box.max[i] - origin[i];
    out.min[i] = round_down(next_below(lo));
    out.max[i] = round_up(-next_below(-hi));
  }
  return out;
}

}  // namespace sightline::core
