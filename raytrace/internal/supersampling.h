// Where the samples of a pixel lie, and which pixels need more than one.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/conventions.h"

namespace sightline::raytrace {

/// Where a sample lies in its pixel, 0 … 1 from the upper left corner: in the cells of a grid of n x n where `samples`
/// is n^2, otherwise at sample_position() (exact_visibility.h).
core::dvec2 sample_in_pixel(int sample, int samples);

/// Marks pixels with 1 where Sobel's gradient of a channel, sqrt(gx^2 + gy^2) and at most 1, exceeds `threshold`. A
/// step of height h between two columns has the gradient 4 h in both. Colours are 0 … 1, in rows of `width`; beyond the
/// border they go on as they are at the border.
///
/// After "Adaptive supersampling based on edges" of RT² (2011), which takes the gradient of grey; channels also find
/// edges between colours that are equally bright.
std::vector<std::uint8_t> mark_edges(std::span<const core::vec3> colours, int width, int height, double threshold);

}  // namespace sightline::raytrace
