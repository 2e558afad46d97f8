// The rays of a picture.
#pragma once

#include "sightline/raytrace/tracer.h"

namespace sightline::raytrace {

/// pixel_ray() for many points of one picture: what depends on the view alone is computed once.
class SIGHTLINE_API PixelRays {
 public:
  /// Fails unless width and height are above 0 and the view's matrices have inverses.
  static core::Expected<PixelRays> create(const core::View& view, int width, int height);

  /// The ray through a point, in pixels from the upper left corner; x and y must be finite. Bit for bit what
  /// pixel_ray() answers.
  Ray through(double x, double y) const;

 private:
  PixelRays(const core::View& view, int width, int height);

  core::dmat4 eye_from_clip_, world_from_eye_;
  core::dvec3 centre_{0.0}, eye_;  ///< where perspective rays meet, before the eye and in the world
  double width_, height_;
  bool orthographic_, reversed_;
};

}  // namespace sightline::raytrace
