// Internal: channels of sRGB and of linear light, both 0 … 1 (IEC 61966-2-1).
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace sightline::core {

inline double linear_from_srgb(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

inline double srgb_from_linear(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
}

/// linear_from_srgb() of all channels of eight bits.
inline std::array<double, 256> linear_from_bytes() {
  std::array<double, 256> linear{};
  for (std::size_t i = 0; i < linear.size(); ++i) linear[i] = linear_from_srgb(double(i) / 255.0);
  return linear;
}

}  // namespace sightline::core
