// Which pixels need more than one sample.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/conventions.h"

namespace sightline::raytrace {

/// Marks pixels with 1 where Sobel's gradient of a channel, sqrt(gx^2 + gy^2) and at most 1, exceeds `threshold`. A
/// step of height h between two columns has the gradient 4 h in both. Colours are 0 … 1, in rows of `width`; beyond the
/// border they go on as they are at the border.
///
/// After "Adaptive supersampling based on edges" of RT² (2011), which takes the gradient of grey; channels also find
/// edges between colours that are equally bright.
std::vector<std::uint8_t> mark_edges(std::span<const core::vec3> colours, int width, int height, double threshold);

}  // namespace sightline::raytrace
