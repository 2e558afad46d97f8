// Makes shapes legible that have one colour: shading and lines that follow from the depth of an image.
#pragma once

#include "sightline/core/view.h"
#include "sightline/render/internal/pixel_pass.h"
#include "sightline/render/internal/render_target.h"

namespace sightline::render {

/// Darkens what lies in corners and behind edges by up to `shading`, after depth darkening (T. Luft, C. Colditz, O.
/// Deussen, "Image Enhancement by Unsharp Masking the Depth Buffer", SIGGRAPH 2006), but by the second difference of
/// depth, which leaves planes as they are, however steep. Draws lines of darkness `lines` where surfaces begin or end
/// and along creases (T. Saito, T. Takahashi, "Comprehensible Rendering of 3-D Shapes", SIGGRAPH 1990). Both are 0 … 1.
///
/// An approximation by looks: it tells nothing about light. It costs 9 reads of depth per pixel, 17 with shading,
/// whatever the scene; of several samples the first stands for the pixel. Nothing is made before the first draw.
class DepthShadingPass {
 public:
  explicit DepthShadingPass(const gl::Functions& gl) : gl_(&gl), pass_(gl) {}

  /// Changes the colour of the image in place; depth and ids stay. `view` is the one that was drawn. Sets GL state
  /// and leaves it set. Fails with the driver's log.
  core::Expected<void> draw(const RenderTarget& image, const core::View& view, float shading, float lines);

 private:
  const gl::Functions* gl_;
  PixelPass pass_;
  gl::Program program_;  // for the samples of the first image
};

}  // namespace sightline::render
