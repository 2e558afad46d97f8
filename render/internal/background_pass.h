// What is behind everything in an image.
#pragma once

#include "sightline/gpuprims/surroundings.h"
#include "sightline/render/internal/pixel_pass.h"

namespace sightline::render {

/// Fills the colour of a framebuffer's part, or of all of it. A background of one colour costs no program.
class BackgroundPass {
 public:
  explicit BackgroundPass(const gl::Functions& gl) : gl_(&gl), pass_(gl) {}

  /// Sets GL state and leaves it set. Fails with the driver's log.
  core::Expected<void> fill(const gpuprims::Background& background, const gl::ExternalTarget& to);

 private:
  void fill_evenly(const core::vec3& colour, const gl::ExternalTarget& to) const;

  const gl::Functions* gl_;
  PixelPass pass_;
  gl::Program program_;  // made with the first background of two colours
};

}  // namespace sightline::render
