#include "sightline/raytrace/internal/ray_frame.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "sightline/raytrace/internal/float4.h"

namespace sightline::raytrace {
namespace {

/// The power of two in (x / 2, x], and 1 / that.
constexpr std::uint64_t kExponent = 0x7ff0000000000000u, kOneOver = 0x7fe0000000000000u;
double power_of_two(double x) {
  return std::bit_cast<double>(std::bit_cast<std::uint64_t>(x) & kExponent);
}
double inverse_power_of_two(double x) {
  return std::bit_cast<double>(kOneOver - (std::bit_cast<std::uint64_t>(x) & kExponent));
}

void set_box_ray(const dvec3& origin, const dvec3& direction, float error, BoxRay& ray) {
  const Float4 o = Float4::of(origin.x, origin.y, origin.z), d = Float4::of(direction.x, direction.y, direction.z);
  const Float4 e = with_signs(Float4::spread(error), d);
  const Float4 inverse = with_signs(Float4::spread(1.0f) / most(magnitude(d), Float4::spread(kLeastDirection)), d);
  (o + e).store(ray.near_origin);
  (o - e).store(ray.far_origin);
  (inverse * Float4::spread(kDown)).store(ray.near_scale);
  (inverse * Float4::spread(kUp)).store(ray.far_scale);
  const unsigned back = signs(d);
  for (int axis = 0; axis < 3; ++axis) {
    const int shift = int(back >> axis & 1u) * 3;
    ray.near_plane[axis] = axis + shift;
    ray.far_plane[axis] = axis + 3 - shift;
  }
}

/// The axis of the largest component, and the other two in turn.
struct Axes {
  int x, y, z;
  explicit Axes(const dvec3& direction) {
    const dvec3 size = glm::abs(direction);
    z = size.z >= size.x && size.z >= size.y ? 2 : size.y >= size.x ? 1 : 0;
    x = z == 2 ? 0 : z + 1;
    y = x == 2 ? 0 : x + 1;
  }
};

/// z at the point of a triangle's outline that is nearest to the origin.
double nearest_edge(const double (&x)[3], const double (&y)[3], const double (&z)[3]) {
  double least = std::numeric_limits<double>::infinity(), result = z[0];
  for (int a = 0; a < 3; ++a) {
    const int b = (a + 1) % 3;
    const double ex = x[b] - x[a], ey = y[b] - y[a], square = ex * ex + ey * ey;
    const double part = square > 0.0 ? std::clamp(-(x[a] * ex + y[a] * ey) / square, 0.0, 1.0) : 0.0;
    const double px = x[a] + part * ex, py = y[a] + part * ey, away = px * px + py * py;
    if (away < least) least = away, result = z[a] + part * (z[b] - z[a]);
  }
  return result;
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

bool enter(const TreeSpace& space, const dvec3& origin, const dvec3& direction, double t_min, double t_max,
           RayFrame& frame) {
  const double longest = std::max(std::fabs(direction.x), std::max(std::fabs(direction.y), std::fabs(direction.z)));
  if (!(longest > 0.0) || space.radius < 0.0) return false;
  const double factor = inverse_power_of_two(longest), per_factor = power_of_two(longest);
  if (!(longest > 0x1p-200 && longest < 0x1p200)) {  // its squares might overflow or vanish
    const bool near = enter(space, origin, factor * direction, t_min * per_factor, t_max * per_factor, frame);
    frame.factor *= factor;
    frame.per_factor *= per_factor;
    return near;
  }
  // Powers of two do not round. So what decides takes the direction as given, and need not wait for its length.
  const dvec3 to_centre = space.centre - origin;
  const dvec3 moment = glm::cross(to_centre, direction);
  const double square = glm::dot(direction, direction);
  const dvec3 far = glm::abs(to_centre);
  const double lost = 1e-15 * (far.x + far.y + far.z) + 2.0 * kBoxError * space.reach;
  const double radius = space.radius + lost;
  if (!(glm::dot(moment, moment) <= radius * radius * square)) return false;
  const double closest = per_factor * (glm::dot(to_centre, direction) / square);
  const double first = std::max(t_min * per_factor, closest - radius);
  const double last = std::min(t_max * per_factor, closest + radius);
  if (!(first <= last)) return false;
  frame.factor = factor;
  frame.per_factor = per_factor;
  frame.margin = kMargin * space.reach;
  frame.begin = first - frame.margin;
  const dvec3 d = frame.direction = factor * direction;
  frame.origin = origin + frame.begin * d;
  set_box_ray(frame.origin, d, float(kBoxError * space.reach), frame.boxes);
  frame.boxes.t_max = frame_limit(last, frame.begin, frame.margin);
  return true;
}

TriangleRay triangle_ray(const RayFrame& frame) {
  const Axes axes(frame.direction);
  const double o[3] = {frame.origin.x, frame.origin.y, frame.origin.z};
  const double d[3] = {frame.direction.x, frame.direction.y, frame.direction.z};
  const double along = 1.0 / d[axes.z];
  return {{axes.x, axes.y, axes.z},
          {float(o[axes.x]), float(o[axes.y]), float(o[axes.z])},
          {float(d[axes.x] * along), float(d[axes.y] * along), float(along)}};
}

double crossing(const RayFrame& frame, const dvec3 (&corners)[3]) {
  const Axes axes(frame.direction);
  const double d[3] = {frame.direction.x, frame.direction.y, frame.direction.z};
  const double along = 1.0 / d[axes.z], shear_x = d[axes.x] * along, shear_y = d[axes.y] * along;
  double x[3], y[3], z[3];
  for (int i = 0; i < 3; ++i) {
    const dvec3 to = corners[i] - frame.origin;
    const double v[3] = {to.x, to.y, to.z};
    x[i] = v[axes.x] - shear_x * v[axes.z];
    y[i] = v[axes.y] - shear_y * v[axes.z];
    z[i] = along * v[axes.z];
  }
  const double u = x[2] * y[1] - y[2] * x[1], v = x[0] * y[2] - y[0] * x[2], w = x[1] * y[0] - y[1] * x[0];
  const double sum = u + v + w;
  const bool inside = std::min(u, std::min(v, w)) >= 0.0 || std::max(u, std::max(v, w)) <= 0.0;
  return inside && sum != 0.0 ? (u * z[0] + v * z[1] + w * z[2]) / sum : nearest_edge(x, y, z);
}

}  // namespace sightline::raytrace
