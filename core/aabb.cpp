#include "sightline/core/aabb.h"

#include <bit>

namespace sightline::core {
namespace {

inline float largest_float_within(double x) {
  if (x >= double(Aabb::kFar)) return Aabb::kFar;
  if (x <= -double(Aabb::kFar)) return -std::numeric_limits<float>::max();
  const float f = static_cast<float>(x);
  // Takes the float before f where f > x. Without a branch, which would be mispredicted every other time. A zero has
  // the sign of x.
  const auto bits = std::bit_cast<std::int32_t>(f);
  return std::bit_cast<float>(bits - (bits >> 31 | 1) * std::int32_t(double(f) > x));
}

}  // namespace

float round_down(double x) {
  return largest_float_within(x);
}

float round_up(double x) {
  return -largest_float_within(-x);
}

Aabb round_outwards(const AabbD& box, const dvec3& origin) {
  if (box.empty()) return {};
  Aabb out;
  for (int i = 0; i < 3; ++i) {
    const double lo = box.min[i] - origin[i], hi = box.max[i] - origin[i];
    out.min[i] = largest_float_within(next_below(lo));
    out.max[i] = -largest_float_within(next_below(-hi));
  }
  return out;
}

}  // namespace sightline::core
