// A framebuffer of the application's, into which an engine puts its image.
#pragma once

#include <cstdint>

namespace sightline::gl {

/// Part of a framebuffer, and what its depth buffer means.
///
/// A view that is drawn into it must have the near and far plane of the matrices with which the application draws
/// there. Then the two hide one another, whichever is drawn first; where both have the same depth, what is drawn first
/// stays. Depths differ from those of triangles by rounding: of the float depth of the image, 2^-24 of a distance in
/// perspective views, and of the depth buffer itself. With several samples per pixel (EngineConfig::drawing.samples)
/// and as many in the framebuffer, each sample gets its own depth and colour; with another number all get the nearest
/// depth of the image's samples, so that lines where it meets other surfaces move by a pixel at most. Its draw buffer
/// must not be GL_NONE.
struct ExternalTarget {
  std::uint32_t framebuffer = 0;  ///< GL's name, in the application's context; 0: the window's
  int x = 0, y = 0;               ///< lower left corner, pixels from that of the framebuffer
  int width = 0, height = 0;      ///< pixels, at least 1
  /// What the depth buffer holds at the near and at the far plane, after glDepthRange. 0 and 1: OpenGL's initial state,
  /// where the projection goes from -1 to 1. 1 and 0: reverse-Z, after glClipControl to 0…1 and with a projection to
  /// 1…0. 0.5 and 1: a projection to 0…1 without glClipControl. They must differ and lie between 0 and 1. The depth
  /// test lets pass what is nearer. A framebuffer without depth buffer gets the whole image.
  double near_depth = 0.0, far_depth = 1.0;
  bool clear_colour = false;   ///< fill the part with the engine's background first
  bool clear_depth = false;    ///< fill its depth buffer with far_depth first
  bool linear_colour = false;  ///< write linear light instead of sRGB values: for framebuffers of floats

  friend bool operator==(const ExternalTarget&, const ExternalTarget&) = default;
};

}  // namespace sightline::gl
