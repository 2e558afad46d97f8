// Internal: where a box lies along the rays of an image, exactly but for rounding. The rectangle of a long box that
// stands askew in the image contains many pixels whose rays miss it.
//
// The ray of the pixel (x, y), centres at integers, is eye + t D(x, y) in a perspective view, and O(x, y) + t D in a
// parallel one; t is the distance along the viewing direction, and D and O are linear in x and y. So the t at which a
// ray crosses the plane of a box's face is a linear function of x and y in a parallel view, and 1 / t is one in a
// perspective view. The key of a distance is the one that is linear: 1 / t, or -t. It falls with the distance in both.
// A ray meets a box where the least key of the near faces is at least the greatest of the far ones (T. Kay, J. Kajiya,
// "Ray tracing complex scenes", 1986), and enters it at the former.
//
// Rounding: near keys are made larger and far keys smaller by all that is lost, so a box is met too often and entered
// too early, never the other way. The eye and D are computed in double; the eye's coordinates are off by at most a
// bound from the residuals of the equations that it solves, by which boxes grow. Functions are evaluated in float with
// a few roundings, each relative to the greatest size of a term: below 2^-20 of the sizes of D's terms in twice the
// image, as far as blocks of pixels reach; 2^-19 of these is added.
#pragma once

#include "sightline/core/view.h"
#include "sightline/culling/occlusion/detail/screen_view.h"

namespace sightline::culling {

class RaySpans {
 public:
  /// `origin`: of the bounds whose boxes will be asked for.
  RaySpans(const core::View& view, const core::dvec3& origin, int width, int height);

  /// The keys of a box: minimum, then maximum, finite and in order. False where nothing is known of it: around the eye,
  /// and in views whose distances are not those of their projection, as a combined matrix has them.
  bool span(const BoxCoordinates& box, BoxSpan& out) const;
  bool parallel() const { return parallel_; }
  /// The rays in float, of places so many pixels from the centres; false where span() knows nothing.
  bool usable() const { return usable_; }
  RayField field(float x = 0.0f, float y = 0.0f) const;

 private:
  struct Projection;
  bool trace_parallel(const Projection& p);
  bool trace_from_eye(const Projection& p);
  bool solve_eye(const Projection& p);
  void add(double per_value, double constant, int axis, double widen, ImageFunction& out) const;
  void span_of_axis(int axis, double low, double high, BoxSpan& out) const;

  struct Axis {
    double constant = 0.0, x = 0.0, y = 0.0;  // perspective: D; parallel: O
    double error = 0.0;                       // of these, with their evaluation in float
    double from = 0.0;                        // perspective: the eye
    double along = 0.0;                       // parallel: D
    double grown = 0.0;                       // metres by which boxes grow
  } axes_[3];
  bool parallel_ = false, usable_ = false;
};

}  // namespace sightline::culling
