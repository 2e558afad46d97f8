#include "sightline/raytrace/internal/ray_frame.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

namespace sightline::raytrace {
namespace {

// In units of TreeSpace::reach, of which a float resolves 2^-24.
constexpr double kBoxError = 0x1p-21;  // of origin, direction and triangle test across the ray
constexpr double kMargin = 0x1p-18;    // along it
// Of a plane's distance: rounding of difference, direction, reciprocal and product.
constexpr float kUp = 1.0f + 0x1p-21f, kDown = 1.0f - 0x1p-21f;
constexpr float kLeastDirection = 0x1p-60f;  // crosses kBoxError only after more than the whole reach

double inverse_power_of_two(double x) {
  return std::bit_cast<double>(0x7fe0000000000000u - (std::bit_cast<std::uint64_t>(x) & 0x7ff0000000000000u));
}

BoxRay box_ray(const dvec3& origin, const dvec3& direction, double error, float t_max) {
  BoxRay ray;
  for (int axis = 0; axis < 3; ++axis) {
    const bool back = std::signbit(direction[axis]);
    const float o = float(origin[axis]), e = back ? -float(error) : float(error);
    const float d = std::max(std::fabs(float(direction[axis])), kLeastDirection), inverse = back ? -1.0f / d : 1.0f / d;
    ray.near_origin[axis] = o + e;
    ray.far_origin[axis] = o - e;
    ray.near_scale[axis] = inverse * kDown;
    ray.far_scale[axis] = inverse * kUp;
    ray.near_plane[axis] = back ? axis + 3 : axis;
    ray.far_plane[axis] = back ? axis : axis + 3;
  }
  ray.t_max = t_max;
  return ray;
}

}  // namespace

TreeSpace space_around(const core::AabbD& box) {
  if (box.empty()) return {};
  TreeSpace space;
  space.centre = box.centre();
  space.radius = glm::length(0.5 * box.size());
  const dvec3 c = glm::abs(space.centre);
  space.reach = std::max(c.x, std::max(c.y, c.z)) + 5.0 * space.radius + 1e-30;
  return space;
}

float RayFrame::limit(double t) const {
  const double s = (t / factor - begin) * (1.0 + 0x1p-20) + margin;
  return s < 1e38 ? float(s) : std::numeric_limits<float>::infinity();
}

bool enter(const TreeSpace& space, const dvec3& origin, const dvec3& direction, double t_min, double t_max,
           RayFrame& frame) {
  const double longest = std::max(std::fabs(direction.x), std::max(std::fabs(direction.y), std::fabs(direction.z)));
  if (!(longest > 0.0) || space.radius < 0.0) return false;
  frame.factor = inverse_power_of_two(longest);
  const dvec3 d = frame.direction = frame.factor * direction;
  const dvec3 to_centre = space.centre - origin;
  const double closest = glm::dot(to_centre, d) / glm::dot(d, d);
  const dvec3 off = to_centre - closest * d;
  const dvec3 far = glm::abs(to_centre);
  const double lost = 1e-15 * (far.x + far.y + far.z) + 2.0 * kBoxError * space.reach;
  const double radius = space.radius + lost;
  if (!(glm::dot(off, off) <= radius * radius)) return false;
  const double first = std::max(t_min / frame.factor, closest - radius);
  const double last = std::min(t_max / frame.factor, closest + radius);
  if (!(first <= last)) return false;
  frame.margin = kMargin * space.reach;
  frame.begin = first - frame.margin;
  frame.origin = origin + frame.begin * d;
  frame.boxes = box_ray(frame.origin, d, kBoxError * space.reach, frame.limit(last * frame.factor));
  return true;
}

TriangleRay triangle_ray(const RayFrame& frame) {
  const dvec3 size = glm::abs(frame.direction);
  const int z = size.z >= size.x && size.z >= size.y ? 2 : size.y >= size.x ? 1 : 0;
  const int x = (z + 1) % 3, y = (z + 2) % 3;
  const auto along = float(1.0 / frame.direction[z]);
  return {{x, y, z},
          {float(frame.origin[x]), float(frame.origin[y]), float(frame.origin[z])},
          {float(frame.direction[x] / frame.direction[z]), float(frame.direction[y] / frame.direction[z]), along}};
}

double crossing(const RayFrame& frame, const dvec3 (&corners)[3], double nearly) {
  const dvec3 size = glm::abs(frame.direction);
  const int z = size.z >= size.x && size.z >= size.y ? 2 : size.y >= size.x ? 1 : 0;
  const int x = (z + 1) % 3, y = (z + 2) % 3;
  const double along = 1.0 / frame.direction[z];
  const double shear_x = frame.direction[x] * along, shear_y = frame.direction[y] * along;
  dvec3 p[3];
  for (int i = 0; i < 3; ++i) {
    const dvec3 v = corners[i] - frame.origin;
    p[i] = {v[x] - shear_x * v[z], v[y] - shear_y * v[z], along * v[z]};
  }
  dvec3 weights = {p[2].x * p[1].y - p[2].y * p[1].x, p[0].x * p[2].y - p[0].y * p[2].x,
                   p[1].x * p[0].y - p[1].y * p[0].x};
  if (weights.x + weights.y + weights.z < 0.0) weights = -weights;
  weights = glm::max(weights, dvec3(0.0));
  const double sum = weights.x + weights.y + weights.z;
  if (!(sum > 0.0)) return nearly;
  return (weights.x * p[0].z + weights.y * p[1].z + weights.z * p[2].z) / sum;
}

}  // namespace sightline::raytrace
