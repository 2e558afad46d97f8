// Draws the image of a small target over all of a larger one.
#pragma once

#include "sightline/render/internal/pixel_pass.h"
#include "sightline/render/internal/render_target.h"

namespace sightline::render {

/// Colours are interpolated between the four nearest pixels; depth and id are those of the nearest one, so that both
/// are of a point that is there. Costs six reads for each pixel of the larger target. Nothing is made before the first
/// draw.
class EnlargePass {
 public:
  explicit EnlargePass(const gl::Functions& gl) : gl_(&gl), pass_(gl) {}

  /// The targets have the same format, without normals, but for the number of samples. Sets GL state and leaves it set. Fails with the driver's log.
  core::Expected<void> draw(const RenderTarget& from, const RenderTarget& to);

 private:
  const gl::Functions* gl_;
  PixelPass pass_;
  gl::Program program_;  // for the format of the first target
};

}  // namespace sightline::render
