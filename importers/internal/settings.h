// Bounds in settings.inc. Internal to importers and bindings.
#pragma once

#include <limits>
#include <numbers>

namespace sightline::importers {

inline constexpr double kAboveZero = std::numeric_limits<double>::denorm_min();
inline constexpr double kAnyFinite = std::numeric_limits<double>::max();
inline constexpr double kMostInt = double(std::numeric_limits<int>::max());
inline constexpr double kPi = std::numbers::pi;

}  // namespace sightline::importers
