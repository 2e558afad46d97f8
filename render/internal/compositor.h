// Puts a picture into a framebuffer of the application's.
#pragma once

#include <array>

#include "sightline/core/external_target.h"
#include "sightline/gl/internal/program.h"
#include "sightline/gl/internal/vertex_array.h"
#include "sightline/render/internal/render_target.h"

namespace sightline::render {

/// Draws the pixels of a target that show anything, with their depths, over the whole part of the application's
/// framebuffer. Where the target has several samples per pixel and the framebuffer as many, it gets each of them;
/// otherwise one pixel: the mean colour of the covered samples, blended by their share, at the least distance. Only
/// fragment output 0 is written.
///
/// A pass of its own, so all that a frame knows about its depth (passes, pyramids, a budget that goes on) stays with
/// our own target, in its float reverse-Z depth, whatever the application's buffer is. It costs one read and one write
/// per pixel, and nothing before the first frame that needs it: one or two programs.
class Compositor {
 public:
  explicit Compositor(const gl::Functions& gl) : gl_(&gl), no_attributes_(gl) {}

  /// `to` must have the size of `from`. `background`: sRGB, to clear with. Sets GL state and leaves it set, with the
  /// framebuffer bound for drawing. Fails on a framebuffer that does not exist or is not complete, on depths out of
  /// range, and with the driver's log.
  core::Expected<void> draw(const RenderTarget& from, const core::ExternalTarget& to,
                            const std::array<float, 3>& background);

 private:
  core::Expected<const gl::Program*> program(int samples, bool each_sample);
  void clear(const core::ExternalTarget& to, const std::array<float, 3>& background) const;

  const gl::Functions* gl_;
  gl::VertexArray no_attributes_;
  gl::Program whole_pixels_, each_sample_;  // for the format of the first target
};

}  // namespace sightline::render
