// The whole renderer as a path of the stability suite: one item drawn into a small image, each pixel's depth a t.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "sightline/bench/stability/measure.h"
#include "sightline/core/view.h"
#include "sightline/gl/context.h"

namespace sightline::bench {

/// One item and who looks at it.
struct Picture {
  core::Primitive primitive;
  core::Affine world_from_item;
  core::Pose pose;
  double fovy = 1.0, near = 0.1, far = core::kInfiniteFar;  ///< radians, metres
  double radius = 1.0;                                      ///< that errors are counted in
};

/// As Case, for pictures. Depth is a float, so t may be off by two ulps of it besides what rays near the item may be;
/// the band is an 128th of a pixel wider, which is less than rasterisers resolve.
struct ViewCase {
  core::Kind kind = core::Kind::kCylinder;
  std::string family;
  double magnitude = 1.0;
  Limits limits;
  Picture picture;

  std::string name() const;
};

/// near-far, field-of-view (degrees), view-offset (metres) and view-distance (radii), of every kind.
std::vector<ViewCase> view_cases(std::uint64_t seed);

class ViewRays {
 public:
  /// Fails where there is no GL.
  static core::Expected<ViewRays> create();

  /// Draws the picture and judges about `rays` of its pixels, of very wide fields of view all. Normals are not read
  /// back.
  core::Expected<Figures> judge_picture(const ViewCase& c, int rays);

 private:
  explicit ViewRays(gl::Context context) : context_(std::move(context)) {}
  gl::Context context_;
};

}  // namespace sightline::bench
