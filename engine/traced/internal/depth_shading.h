// Depth shading of an image in main memory: twin of render/shaders/depth_shading.frag. Internal to engine.
#pragma once

#include <cstdint>
#include <span>

#include "sightline/core/conventions.h"
#include "sightline/core/thread_pool.h"
#include "sightline/engine/looks.h"

namespace sightline::engine {

/// Rows from the bottom up. Borrows.
struct ShadedImage {
  int width, height;
  std::span<std::uint32_t> colours;  ///< red in the lowest byte, then g, b
  std::span<const float> depths;     ///< reversed; 0: nothing is drawn
};

/// Darkens the colours by their depths. `pixel_depth`: gpuprims::pixel_depth() of the image. A GPU's result differs by
/// the rounding of floats.
void shade(const ShadedImage& image, const glm::vec2& pixel_depth, const DepthShading& looks,
           core::ThreadPool& threads);

}  // namespace sightline::engine
