// The error of a plane's value when GLSL evaluates it.
#pragma once

#include <algorithm>
#include <cmath>

#include "sightline/core/item_bounds.h"

namespace sightline::culling {

/// The band of a FloatPlane (frustum_test.h) when the GPU evaluates it, over `bounds`. GLSL says that operations are
/// correctly rounded, but not in which direction: an error of up to 2^-23 each, where the CPU has 2^-24. GLSL may also
/// flush every denormal to zero: of the plane (times a coordinate), of a coordinate (times less than 1), of three
/// products and three sums, at most 2^-126 each.
inline double gpu_band(float band, const core::ItemBounds& bounds) {
  double sizes = 8.0;
  if (!bounds.extent().empty())
    for (int i = 0; i < 3; ++i)
      sizes += std::max(std::abs(double(bounds.extent().min[i])), std::abs(double(bounds.extent().max[i])));
  return 2.0 * double(band) + 0x1p-126 * sizes;
}

}  // namespace sightline::culling
