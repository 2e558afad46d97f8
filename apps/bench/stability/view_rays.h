// Tests the whole renderer as a path of the stability suite: draws one item into a small image, where each pixel's
// depth is a t.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "sightline/apps/bench/stability/measure.h"
#include "sightline/core/view.h"
#include "sightline/gl/context.h"

namespace sightline::bench {

/// One item and the camera that sees it.
struct Image {
  core::Primitive primitive;
  core::Affine world_from_item;
  core::Pose pose;
  double fovy = 1.0, near = 0.1, far = core::kInfiniteFar;  ///< radians, metres
  double radius = 1.0;                                      ///< unit of errors
};

/// Like Case, for images. Depth is a float, so t may be off by two ulps of it in addition to the limits for rays near
/// the item. The band is wider by a 128th of a pixel, which is less than rasterisers resolve.
struct ViewCase {
  core::Kind kind = core::Kind::kCylinder;
  std::string family;
  double magnitude = 1.0;
  Limits limits;
  Image image;

  std::string name() const;
};

/// Families near-far, field-of-view (degrees), view-offset (metres) and view-distance (radii), of every kind.
std::vector<ViewCase> view_cases(std::uint64_t seed);

class ViewRays {
 public:
  /// Fails without GL.
  static core::Expected<ViewRays> create(gl::ContextPlatform platform = {});

  /// Draws the image and judges about `rays` of its pixels, or all of them for very wide fields of view. Does not
  /// read back normals.
  core::Expected<CaseErrors> judge_image(const ViewCase& c, int rays);

 private:
  explicit ViewRays(gl::Context context) : context_(std::move(context)) {}
  gl::Context context_;
};

}  // namespace sightline::bench
