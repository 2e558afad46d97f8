// The rays of a picture.
//
// A place x, y in the picture is where the forms X - x W and Y - y W vanish, X, Y and W being rows of the projection.
// So its ray points along the cross product of their gradients, which is linear in x and y:
// (X x Y) + x (Y x W) + y (W x X).
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
  /// A function of a place in the picture, x and y from -1 to 1.
  template <class Value>
  struct Linear {
    Value constant{}, per_x{}, per_y{};
    Value at(double x, double y) const { return constant + x * per_x + y * per_y; }
  };
  PixelRays(const core::View& view, int width, int height);

  double width_, height_;
  bool orthographic_;
  core::dvec3 eye_{0.0};               ///< where perspective rays meet
  Linear<core::dvec3> origin_;         ///< of orthographic rays, on the near plane
  Linear<core::dvec3> direction_;      ///< of any length
  Linear<double> per_near_, per_far_;  ///< steps of the direction's length to the planes, from the eye: 1 / these
  double depth_ = 0.0;                 ///< the same of orthographic rays, from the near to the far plane
};

}  // namespace sightline::raytrace
