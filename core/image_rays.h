// The rays of an image, one through each point of it.
//
// A place x, y in the image is where the forms X - x W and Y - y W vanish, X, Y and W being rows of the projection.
// So its ray points along the cross product of their gradients, which is linear in x and y:
// (X x Y) + x (Y x W) + y (W x X).
#pragma once

#include <vector>

#include "sightline/core/api.h"
#include "sightline/core/error.h"
#include "sightline/core/ray.h"
#include "sightline/core/view.h"

namespace sightline::core {

/// image_ray() for many points of one image: what depends on the view alone is computed once.
class SIGHTLINE_API ImageRays {
 public:
  /// Fails unless width and height are above 0 and the view's matrices have inverses.
  static Expected<ImageRays> create(const View& view, int width, int height);

  /// The ray through a point, in pixels from the upper left corner; x and y must be finite. Bit for bit what
  /// image_ray() answers.
  Ray through(double x, double y) const;

 private:
  /// A function of a place in the image, x and y from -1 to 1.
  template <class Value>
  struct Linear {
    Value constant{}, per_x{}, per_y{};
    Value at(double x, double y) const { return constant + x * per_x + y * per_y; }
  };
  ImageRays(const View& view, int width, int height);

  double width_, height_;
  bool orthographic_;
  dvec3 eye_{0.0};                     ///< where perspective rays meet
  Linear<dvec3> origin_;               ///< of orthographic rays, on the near plane
  Linear<dvec3> direction_;            ///< of any length
  Linear<double> per_near_, per_far_;  ///< steps of the direction's length to the planes, from the eye: 1 / these
  double depth_ = 0.0;                 ///< the same of orthographic rays, from the near to the far plane
};

/// The ray through a point of an image, in pixels from its upper left corner: the middle of the first pixel is at 0.5,
/// 0.5. From the eye, or in orthographic views from the near plane. The direction has unit length; t_min and t_max are
/// at the near and far plane. Fails when the view's matrices have no inverse or the point is not finite.
SIGHTLINE_API Expected<Ray> image_ray(const View& view, int width, int height, double x, double y);

/// Places in a pixel, 0 … 1 from its upper left corner, so many of them, 1 or more: one in each row and in each column
/// of a grid of samples x samples, so that edges along either get as many shades. Their mean is the pixel's middle. In
/// the order of the Hammersley set; four are turned, since those would lie along the diagonal.
SIGHTLINE_API std::vector<dvec2> rook_positions(int samples);

}  // namespace sightline::core
