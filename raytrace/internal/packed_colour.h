// Colours as four bytes. Internal to raytrace.
#pragma once

#include <algorithm>
#include <cstdint>

#include "sightline/core/conventions.h"
#include "sightline/gpuprims/surroundings.h"

namespace sightline::raytrace {

/// Red in the lowest byte, then green, blue, and alpha.
inline std::uint32_t packed_colour(const core::vec3& colour, float alpha = 1.0f) {
  const auto byte = [](float channel) { return std::uint32_t(255.0f * std::clamp(channel, 0.0f, 1.0f) + 0.5f); };
  return byte(colour.r) | byte(colour.g) << 8 | byte(colour.b) << 16 | byte(alpha) << 24;
}
/// The background's colour in a row of an image, counted from the bottom up.
inline std::uint32_t background_of(const gpuprims::Background& background, int row, int height) {
  return packed_colour(glm::mix(background.bottom, background.top, (float(row) + 0.5f) / float(height)));
}
/// Whatever the highest byte holds.
inline core::vec3 colour_of(std::uint32_t packed) {
  return core::vec3(packed & 255u, packed >> 8 & 255u, packed >> 16 & 255u) / 255.0f;
}

}  // namespace sightline::raytrace
