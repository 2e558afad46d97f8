// An image as the GPU culler's shaders see it. Internal to culling/gpu.
#pragma once

#include <cstdint>

#include "sightline/core/item_bounds.h"
#include "sightline/core/view.h"
#include "sightline/culling/gpu/internal/gpu_bounds.h"
#include "sightline/culling/occlusion/sample_test.h"

namespace sightline::culling {

/// ScreenBlock of screen_box.glsl (std140).
struct ScreenBlock {
  struct Row {
    float of_form[4];  // place x, place y, w, distance
  };
  Row along[3], constant, band[3], band_constant;
  float last[2], largest;
  std::int32_t sample_count;
  float snap, unused[3];
  float samples[kMaxSamples][4];
};
static_assert(sizeof(ScreenBlock) == 16 * (10 + kMaxSamples));

/// `samples` has at most kMaxSamples offsets.
ScreenBlock make_screen_block(const core::View& view, const core::ItemBounds& bounds, const ImageSamples& samples);

}  // namespace sightline::culling
