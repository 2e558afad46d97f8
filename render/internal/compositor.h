// Puts what a target shows over a framebuffer, the application's or one of ours.
#pragma once

#include <array>
#include <optional>

#include "sightline/render/internal/background_pass.h"
#include "sightline/render/internal/pixel_pass.h"
#include "sightline/render/internal/render_target.h"

namespace sightline::render {

/// Fails on a framebuffer that does not exist or is not complete, on depths out of range, and on a rectangle whose
/// corners are no numbers of GL.
core::Expected<void> check_target(const gl::Functions& gl, const gl::ExternalTarget& to);

/// Draws the pixels of a target that show anything, with their depths, over the whole part of a framebuffer. Where the
/// target has several samples per pixel and the framebuffer as many, it gets each of them; otherwise one pixel: the
/// mean of the samples, blended by the share that is covered, at the least distance. Only fragment output 0 is written.
///
/// A pass of its own, so all that a frame knows about its depth (passes, pyramids, a budget that goes on) stays with
/// our own target, in its float reverse-Z depth, whatever the application's buffer is. It costs one read and one write
/// per pixel, and nothing before the first frame that needs it: one or two programs.
class Compositor {
 public:
  enum class Source {
    kImage,  ///< its depth says where it shows anything
    kLayer,  ///< its alpha does; colours are multiplied by it, blended, and write no depth
  };

  explicit Compositor(const gl::Functions& gl, Source source = Source::kImage) : gl_(&gl), pass_(gl), source_(source) {}

  /// As put(), into a framebuffer of the application's, which is cleared first where it says so. `to` must have the
  /// size of `from`. `background`: to clear with. Fails as check_target() does.
  core::Expected<void> draw(const RenderTarget& from, const gl::ExternalTarget& to,
                            const gpuprims::Background& background);
  /// Sets GL state and leaves it set, with the framebuffer bound for drawing. Fails with the driver's log.
  core::Expected<void> put(const RenderTarget& from, const gl::ExternalTarget& to);

 private:
  core::Expected<void> clear(const gl::ExternalTarget& to, const gpuprims::Background& background);

  const gl::Functions* gl_;
  PixelPass pass_;
  Source source_;
  std::optional<BackgroundPass> background_pass_;  // made with the first framebuffer that is to be cleared
  gl::Program whole_pixels_, each_sample_;         // for the format of the first target
};

}  // namespace sightline::render
