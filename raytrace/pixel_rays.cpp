#include "sightline/raytrace/pixel_rays.h"

#include <cmath>
#include <limits>

#include "sightline/core/conventions.h"

namespace sightline::raytrace {
namespace {

using core::dvec3;
using core::dvec4;

bool finite(const Ray& ray) {
  return core::is_finite(ray.origin) && core::is_finite(ray.direction);
}

}  // namespace

PixelRays::PixelRays(const core::View& view, int width, int height)
    : eye_from_clip_(glm::inverse(view.clip_from_eye())),
      world_from_eye_(glm::inverse(view.eye_from_world())),
      width_(width),
      height_(height),
      orthographic_(view.orthographic()),
      reversed_(view.clip_depth() == core::ClipDepth::kReversedZeroToOne) {
  const dvec4 eye = eye_from_clip_ * dvec4(0.0, 0.0, 1.0, 0.0);
  if (eye.w != 0.0) centre_ = dvec3(eye) / eye.w;
  eye_ = dvec3(world_from_eye_ * dvec4(centre_, 1.0));
}

core::Expected<PixelRays> PixelRays::create(const core::View& view, int width, int height) {
  if (width <= 0 || height <= 0) return core::fail("pixel_ray: width and height must be above 0");
  const PixelRays rays(view, width, height);
  if (!finite(rays.through(0.5, 0.5))) return core::fail("pixel_ray: the view's matrices must have inverses");
  return rays;
}

Ray PixelRays::through(double x, double y) const {
  const double sx = 2.0 * x / width_ - 1.0, sy = 1.0 - 2.0 * y / height_;
  const dvec4 near = eye_from_clip_ * dvec4(sx, sy, reversed_ ? 1.0 : -1.0, 1.0);
  const dvec4 far = eye_from_clip_ * dvec4(sx, sy, reversed_ ? 0.0 : 1.0, 1.0);
  // The homogeneous points' difference points along the ray even if one of them is infinitely far away.
  dvec3 along = dvec3(far) * near.w - dvec3(near) * far.w;
  if (near.w * far.w < 0.0) along = -along;
  along = glm::normalize(along);
  const dvec3 start = dvec3(near) / near.w;
  const double depth =
      far.w == 0.0 ? std::numeric_limits<double>::infinity() : glm::dot(dvec3(far) / far.w - start, along);
  const dvec3 in_world = core::dmat3(world_from_eye_) * along;
  const double scale = glm::length(in_world);
  Ray ray;
  ray.direction = glm::normalize(in_world);
  if (orthographic_) {
    ray.origin = dvec3(world_from_eye_ * dvec4(start, 1.0));
    ray.t_max = depth * scale;
  } else {
    const double to_start = glm::dot(start - centre_, along);
    ray.origin = eye_;
    ray.t_min = to_start * scale;
    ray.t_max = (to_start + depth) * scale;
  }
  return ray;
}

core::Expected<Ray> pixel_ray(const core::View& view, int width, int height, double x, double y) {
  if (!std::isfinite(x) || !std::isfinite(y) || width <= 0 || height <= 0)
    return core::fail("pixel_ray: the point must be finite, width and height above 0");
  const auto rays = PixelRays::create(view, width, height);
  if (!rays) return tl::unexpected(rays.error());
  const Ray ray = rays->through(x, y);
  if (!finite(ray)) return core::fail("pixel_ray: the view's matrices must have inverses");
  return ray;
}

}  // namespace sightline::raytrace
