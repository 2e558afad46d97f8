#include "sightline/core/image_rays.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include "sightline/core/affine.h"

namespace sightline::core {
namespace {

bool finite(const Ray& ray) {
  return is_finite(ray.origin) && is_finite(ray.direction);
}

}  // namespace

ImageRays::ImageRays(const View& view, int width, int height)
    : width_(width), height_(height), orthographic_(view.orthographic()) {
  const dmat4 rows = glm::transpose(view.clip_from_eye()), eye_from_clip = glm::inverse(view.clip_from_eye());
  const dmat4 world_from_eye = glm::inverse(view.eye_from_world());
  const double near_z = near_depth(view.clip_depth()), far_z = far_depth(view.clip_depth());
  const dvec4 near = rows[2] - near_z * rows[3], far = rows[2] - far_z * rows[3];
  const dvec3 x(rows[0]), y(rows[1]), w(rows[3]);
  Linear<dvec3> along{glm::cross(x, y), glm::cross(y, w), glm::cross(w, x)};
  // Forwards is where w grows, or from the near to the far plane.
  const double forwards =
      orthographic_ ? glm::dot(dvec3(rows[2]), along.constant) * (far_z - near_z) : glm::dot(w, along.constant);
  const double scale = std::copysign(1.0 / glm::length(along.constant), forwards);
  for (dvec3* part : {&along.constant, &along.per_x, &along.per_y}) *part *= scale;
  const auto turned = [&](const dvec3& direction) { return dmat3(world_from_eye) * direction; };
  direction_ = {turned(along.constant), turned(along.per_x), turned(along.per_y)};
  if (orthographic_) {
    const auto on_near = [&](double at_x, double at_y) {
      const dvec4 place = eye_from_clip * dvec4(at_x, at_y, near_z, 1.0);
      return dvec3(place) / place.w;
    };
    const dvec3 middle = on_near(0.0, 0.0);
    origin_ = {dvec3(world_from_eye * dvec4(middle, 1.0)), turned(on_near(1.0, 0.0) - middle),
               turned(on_near(0.0, 1.0) - middle)};
    depth_ = -glm::dot(far, dvec4(middle, 1.0)) / glm::dot(dvec3(far), along.constant);
    return;
  }
  const dvec4 homogeneous = eye_from_clip * dvec4(0.0, 0.0, 1.0, 0.0);
  const dvec3 eye = dvec3(homogeneous) / homogeneous.w;
  eye_ = dvec3(world_from_eye * dvec4(eye, 1.0));
  const auto per_step = [&](const dvec4& plane) {
    const dvec3 rate = dvec3(plane) / -glm::dot(plane, dvec4(eye, 1.0));
    return Linear<double>{glm::dot(rate, along.constant), glm::dot(rate, along.per_x), glm::dot(rate, along.per_y)};
  };
  per_near_ = per_step(near);
  per_far_ = per_step(far);
}

Expected<ImageRays> ImageRays::create(const View& view, int width, int height) {
  if (width <= 0 || height <= 0) return fail("image_ray: width and height must be above 0");
  const ImageRays rays(view, width, height);
  if (!finite(rays.through(0.5, 0.5))) return fail("image_ray: the view's matrices must have inverses");
  return rays;
}

Ray ImageRays::through(double x, double y) const {
  const double at_x = 2.0 * x / width_ - 1.0, at_y = 1.0 - 2.0 * y / height_;
  const dvec3 along = direction_.at(at_x, at_y);
  const double length = glm::length(along);
  Ray ray;
  ray.direction = along / length;
  if (orthographic_) {
    ray.origin = origin_.at(at_x, at_y);
    ray.t_max = depth_ * length;
    return ray;
  }
  const double per_far = per_far_.at(at_x, at_y);
  ray.origin = eye_;
  ray.t_min = length / per_near_.at(at_x, at_y);
  ray.t_max = per_far > 0.0 ? length / per_far : std::numeric_limits<double>::infinity();
  return ray;
}

Expected<Ray> image_ray(const View& view, int width, int height, double x, double y) {
  if (!std::isfinite(x) || !std::isfinite(y) || width <= 0 || height <= 0)
    return fail("image_ray: the point must be finite, width and height above 0");
  const auto rays = ImageRays::create(view, width, height);
  if (!rays) return tl::unexpected(rays.error());
  const Ray ray = rays->through(x, y);
  if (!finite(ray)) return fail("image_ray: the view's matrices must have inverses");
  return ray;
}

std::vector<dvec2> rook_positions(int samples) {
  assert(samples > 0);
  if (samples == 4) return {{0.375, 0.125}, {0.875, 0.375}, {0.125, 0.625}, {0.625, 0.875}};
  std::vector<std::pair<double, int>> order;  // by the radical inverse
  for (int i = 0; i < samples; ++i) {
    double inverse = 0.0, digit = 0.5;
    for (int rest = i; rest > 0; rest /= 2, digit *= 0.5) inverse += rest % 2 * digit;
    order.emplace_back(inverse, i);
  }
  std::sort(order.begin(), order.end());
  std::vector<dvec2> positions(static_cast<std::size_t>(samples));
  for (int row = 0; row < samples; ++row) {
    const int i = order[std::size_t(row)].second;
    positions[std::size_t(i)] = {(i + 0.5) / samples, (row + 0.5) / samples};
  }
  return positions;
}

}  // namespace sightline::core
