// A box in eight bytes: its corners on a grid of 1024 steps across a box around it, rounded outwards.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "sightline/core/aabb.h"

namespace sightline::culling {

/// As shaders/compact_box.glsl reads it.
struct CompactBox {
  static constexpr std::uint32_t kVacant = 1u << 31;

  std::uint32_t low = 0;   ///< ten bits each of x, y, z: steps from the lower corner; kVacant: there is no item
  std::uint32_t high = 0;  ///< from the upper corner
};

namespace detail {
/// The largest number of steps for which GLSL, which computes base + steps * ((end - base) / 1024), stays below
/// `value`.
///
/// Of GLSL, operations are known to be correctly rounded (not which way: 2^-23) and denormals to be kept or flushed
/// (2^-126). With s the exact step and d = value - base: thousandths of base and end are exact but for denormals, so
/// the step is off by 2^-23 s + 3 * 2^-126, its multiple by 2^-22 d (1 + 2^-22) + 2^-114, and the sum by another 2^-23
/// of itself, which lies between base and value. No steps give base itself, a corner of the box around.
inline std::uint32_t steps_within(double base, double end, double value) {
  const double step = (end - base) / 1024.0, distance = value - base;
  const double error = 1.01 * (0x1p-22 * distance + 0x1p-23 * std::max(std::abs(base), std::abs(value))) + 0x1p-113;
  const double steps = std::floor((distance - error) / step);
  const bool overflows = distance > 0.25 * double(std::numeric_limits<float>::max());
  return steps >= 1.0 && !overflows ? std::uint32_t(std::min(steps, 1023.0)) : 0u;
}
}  // namespace detail

/// `around` contains `box`. What GLSL makes of it contains `box`, too.
inline CompactBox compact(const core::Aabb& box, const core::Aabb& around) {
  CompactBox made;
  for (int i = 0; i < 3; ++i) {
    const double low = around.min[i], high = around.max[i];
    made.low |= detail::steps_within(low, high, box.min[i]) << (10 * i);
    made.high |= detail::steps_within(-high, -low, -double(box.max[i])) << (10 * i);
  }
  return made;
}

}  // namespace sightline::culling
